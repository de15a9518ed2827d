// Which elements of an output have changed, from the fit with all of them free.
// Internal to mle/nonlinear.
//
// With the estimated changes δ̂ and their covariance C, and for element g the
// block C_gg of its own (K, T, L), z_g = S_g δ_g with S_gᵀ S_g = C_gg⁻¹ is its
// change in units of its uncertainty, and ‖ẑ_g‖² is Wald's statistic against
// "g has not changed". The adaptive group lasso on the likelihood's quadratic
// (Wang and Leng, Comput. Stat. Data Anal. 52, 2008)
//
//   min ½ (δ − δ̂)ᵀ C⁻¹ (δ − δ̂) + Σ_g λ_g ‖z_g‖ / ‖ẑ_g‖
//
// sets whole groups to zero. While the others are free to follow, the slope
// that holds group g at zero is ẑ_g itself, so that g stays at zero exactly if
// ‖ẑ_g‖² ≤ λ_g: λ_g is a critical value of Wald's test, and it is set by the
// probability of a false alarm. The others' penalty keeps exchangeable changes
// from being shared. Where the others are held at zero as
// well, g may have to answer for them: a group is taken to have changed only if
// Wald's own test says so too, which keeps the probability.

#ifndef MLE_NONLINEAR_OUTPUT_ERROR_SELECTION_H_
#define MLE_NONLINEAR_OUTPUT_ERROR_SELECTION_H_

#include <vector>

#include "Eigen/Core"

namespace mle {

struct ElementSelection {
  std::vector<double> statistics;  // ‖ẑ_g‖²
  std::vector<double> p_values;    // of Wald's F test
  std::vector<bool> changed;
};

// `changes` δ̂ (3g), `covariance` C (3g × 3g, positive definite) and
// `degrees_of_freedom` (g) of each group's covariance, where every group is
// tested at the probability `false_alarm`.
ElementSelection SelectChanged(const Eigen::VectorXd& changes,
                               const Eigen::MatrixXd& covariance,
                               const std::vector<double>& degrees_of_freedom,
                               double false_alarm);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_ERROR_SELECTION_H_
