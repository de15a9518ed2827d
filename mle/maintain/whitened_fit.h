// Gains of known responses in an output that is disturbed in an unknown way:
//
//   y_k = Σ_j a_j c_jk + w_k,   w_k = b + Σ_{l=1..n} φ_l w_{k−l} + e_k,
//
// with an autoregression of order n, 12 if nothing else is said, for drifts,
// coloured noise and periods. The likelihood is that of the innovations e, in
// which feedback does no harm: a controller that answers w moves the inputs
// later than e. By generalised least squares, φ and a in turn; the offset b is
// each window's own.

#ifndef MLE_MAINTAIN_WHITENED_FIT_H_
#define MLE_MAINTAIN_WHITENED_FIT_H_

#include <vector>

#include "Eigen/Core"

namespace mle {

constexpr int kWhitenedOrder = 12;

// One output in all windows; without gaps.
struct WhitenedData {
  std::vector<Eigen::VectorXd> outputs;    // N
  std::vector<Eigen::MatrixXd> responses;  // N × m
};

// The means of blocks of `length` samples. Long blocks forgive a model whose
// shape is a little wrong, which costs likelihood at every sample.
WhitenedData BlockMeans(const WhitenedData& data, int length);

// The increments of outputs and responses from sample to sample, 0 at the
// first: of an output that integrates neither level nor balance are known, and
// the increments have their offset in b.
WhitenedData Increments(const WhitenedData& data);

struct WhitenedFit {
  Eigen::VectorXd gains;   // a (m); as at the start where a response is zero
  Eigen::VectorXd errors;  // their standard errors, infinite there
  double log_likelihood = 0.0;
};

// −N/2 ln σ_e² at gains a; σ_e at least 10⁻⁴ of the outputs' deviation.
double WhitenedLogLikelihood(const WhitenedData& data,
                             const Eigen::VectorXd& gains);

// Outputs and responses through the filter 1 − Σ φ_l q^−l that
// FitWhitenedGains() ends with at these gains, less their means; windows of up
// to 2n samples are empty.
WhitenedData Whiten(const WhitenedData& data, const Eigen::VectorXd& gains);

// `order` is n ≥ 1. The fit ends where the gains move by less than 10⁻³ of
// their standard errors.
WhitenedFit FitWhitenedGains(const WhitenedData& data, Eigen::VectorXd start,
                             int order = kWhitenedOrder);

// The log-likelihood with few gains free, all others 1, less ½ ln N for each
// that is: of those left in turn the one that explains most of the innovations,
// as long as it is worth its price.
double FewGainsLogLikelihood(const WhitenedData& data);

// −φ_n … −φ_1, 1 (n + 1) of what the responses leave at gains a.
Eigen::VectorXd WhiteningFilter(const WhitenedData& data,
                                const Eigen::VectorXd& gains, int order);

// The series of a window through such a filter, less its mean: N − n samples.
Eigen::VectorXd ApplyFilter(const Eigen::VectorXd& filter,
                            const Eigen::Ref<const Eigen::VectorXd>& values);

}  // namespace mle

#endif  // MLE_MAINTAIN_WHITENED_FIT_H_
