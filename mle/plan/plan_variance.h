// The variance of a parameter as a function of a plan's size. Internal to
// mle/plan.
//
// With what is known before, I₀ = L Lᵀ, and the information s² I of a plan of
// size s, the eigenvalues λ_l of L⁻¹ I L⁻ᵀ and c = Vᵀ L⁻¹ e of the parameter e
// give its variance,
//
//   eᵀ (I₀ + s² I)⁻¹ e = Σ_l c_l²/(1 + s² λ_l).

#ifndef MLE_PLAN_PLAN_VARIANCE_H_
#define MLE_PLAN_PLAN_VARIANCE_H_

#include <vector>

#include "Eigen/Core"

namespace mle {

inline constexpr double kLargestSize = 1e9;

struct VarianceOfSize {
  Eigen::VectorXd squares;  // c_l²
  Eigen::VectorXd growth;   // λ_l

  double At(double size) const;
};

// `root` is L.
VarianceOfSize VarianceOf(const Eigen::MatrixXd& root,
                          const Eigen::MatrixXd& information,
                          Eigen::Index place);

using Variances = std::vector<VarianceOfSize>;  // of each plant

double MeanAt(const Variances& variances, double size);
// The least size whose mean variance is `wanted`; infinite beyond kLargestSize.
double LeastSizeFor(const Variances& variances, double wanted);

}  // namespace mle

#endif  // MLE_PLAN_PLAN_VARIANCE_H_
