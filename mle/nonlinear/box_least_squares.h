// Least squares within bounds by Gauss and Newton: min ½‖r(x)‖², l ≤ x ≤ u.
// Internal to mle/nonlinear.
//
// A step d minimises the model's cost within the bounds,
//
//   gᵀd + ½ dᵀ(H + μ diag H) d,   g = Jᵀr,  H = JᵀJ,   l ≤ x + d ≤ u,
//
// exactly (MinimiseQuadratic): unknowns at a bound do not slow the others, as
// they do where a step without bounds is projected. μ falls with steps that
// lower the cost as the model says and rises with those that do not
// (Levenberg, Marquardt), at once to where it shortens them. Each step takes
// one evaluation with derivatives and O(n³) operations for each exchange of
// bounds.

#ifndef MLE_NONLINEAR_BOX_LEAST_SQUARES_H_
#define MLE_NONLINEAR_BOX_LEAST_SQUARES_H_

#include <functional>

#include "Eigen/Core"

namespace mle {

// The d with lower ≤ d ≤ upper (entries may be equal) that minimises
// gᵀd + ½ dᵀHd, H positive definite: block principal pivoting (Júdice and
// Pires, Computers & Operations Research 21, 1994).
Eigen::VectorXd MinimiseQuadratic(const Eigen::MatrixXd& H,
                                  const Eigen::VectorXd& g,
                                  const Eigen::VectorXd& lower,
                                  const Eigen::VectorXd& upper);

// ½‖r‖² and its model at a point.
struct QuadraticModel {
  double cost = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;  // JᵀJ
};

struct BoxLeastSquaresOptions {
  int max_iterations = 100;  // ≥ 1
  // Stops, with that step taken, before one that lowers the model's cost by
  // less than this share.
  double tolerance = 1e-8;
};

struct BoxLeastSquaresSummary {
  double cost = 0.0;  // at the end
  int iterations = 0;
  // No step lowers the cost by more; if not, the iterations were too few.
  bool converged = false;
};

// From and to `x`, which is moved within the bounds first.
BoxLeastSquaresSummary MinimiseWithinBox(
    const std::function<QuadraticModel(const Eigen::VectorXd&)>& evaluate,
    const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
    const BoxLeastSquaresOptions& options, Eigen::VectorXd& x);

}  // namespace mle

#endif  // MLE_NONLINEAR_BOX_LEAST_SQUARES_H_
