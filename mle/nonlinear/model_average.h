// One output's fits under different noise, averaged by weights that add up to
// one. Internal to mle/nonlinear.
//
//   θ̄ = Σ w_a θ_a,   V̄ = Σ w_a (V_a + (θ_a − θ̄)(θ_a − θ̄)ᵀ),
//
// and intervals from the mixture of the fits' t distributions. (Buckland,
// Burnham and Augustin, Biometrics 53, 1997.)

#ifndef MLE_NONLINEAR_MODEL_AVERAGE_H_
#define MLE_NONLINEAR_MODEL_AVERAGE_H_

#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_fit.h"

namespace mle {

struct WeightedFit {
  double weight = 1.0;
  const OutputFit* fit = nullptr;
};

// Fits of an output and their weights, which add up to one.
struct Mixture {
  std::vector<double> weights;
  std::vector<OutputFit> fits;

  void Add(double weight, OutputFit fit);
  // `fit` as it is under each of `estimates`, with `weight` in all; within
  // `bounds`.
  void AddShifted(double weight, const OutputFit& fit,
                  std::vector<LinearEstimate> estimates,
                  const OutputFitBounds& bounds);
  std::vector<WeightedFit> parts() const;
};

// K, T, L of each element in turn (3m); 0 for absent ones.
Eigen::VectorXd ParametersOf(const OutputPoint& point);

// θ̄ and V̄; noise, deviance and certificate of the heaviest fit, but confirmed
// only where all are, and with the largest gradient. Dead times lie in the
// samples that they begin.
OutputFit Average(const std::vector<WeightedFit>& fits, double sample_time);

// Parameter number `index` is below `low` with probability (1 − confidence)/2,
// and above `high`. One point where its variance is 0, all numbers where it is
// not finite.
struct Interval {
  double low = 0.0;
  double high = 0.0;
};
Interval MixtureInterval(const std::vector<WeightedFit>& fits, int index,
                         double confidence);

// The change δ of parameter number `index` alone that makes the likelihood
// ratio −2 ln Σ w_a exp(−δ²/2V_a) reach `statistic`, V = 1/(C⁻¹)_ii its
// variance where the other parameters are known: the test of all parameters has
// the statistic δ²/V where one of them has changed. Infinite where C_ii is not
// finite.
double DetectableChange(const std::vector<WeightedFit>& fits, int index,
                        double statistic);

}  // namespace mle

#endif  // MLE_NONLINEAR_MODEL_AVERAGE_H_
