// The time scale that decides how fine an integration must step.

#ifndef SIM_FASTEST_TIME_CONSTANT_H_
#define SIM_FASTEST_TIME_CONSTANT_H_

#include <vector>

#include "Eigen/Core"

namespace mle::sim {

// 1 / max |pole| of a polynomial in s, highest power first, of degree ≥ 1 with
// a leading coefficient other than zero. Accurate in any unit of time.
double FastestTimeConstant(const std::vector<double>& denominator);

// 1 / max |eigenvalue| of A: r × r, r ≥ 1; +∞ where all are zero.
double FastestTimeConstant(const Eigen::MatrixXd& A);

}  // namespace mle::sim

#endif  // SIM_FASTEST_TIME_CONSTANT_H_
