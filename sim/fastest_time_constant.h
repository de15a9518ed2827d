// The time scale that decides how fine an integration must step.

#ifndef SIM_FASTEST_TIME_CONSTANT_H_
#define SIM_FASTEST_TIME_CONSTANT_H_

#include "Eigen/Core"

namespace mle::sim {

// 1 / max |eigenvalue| of A: r × r, r ≥ 1; +∞ where all are zero.
double FastestTimeConstant(const Eigen::MatrixXd& A);

}  // namespace mle::sim

#endif  // SIM_FASTEST_TIME_CONSTANT_H_
