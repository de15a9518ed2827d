// The steady state of a plant given by differential equations.
//
// Newton's method on f(0, x, w) = 0 with a numeric Jacobian and step halving.
// (Dennis and Schnabel, Numerical Methods for Unconstrained Optimization and
// Nonlinear Equations, 1983, ch. 6.)

#ifndef SIM_STEADY_STATE_H_
#define SIM_STEADY_STATE_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "sim/continuous_plant.h"

namespace mle::sim {

// ∂f/∂x and ∂f/∂w at (x, w) by central differences.
struct Linearisation {
  Eigen::MatrixXd A;  // n × n
  Eigen::MatrixXd B;  // n × q
};
Linearisation Linearise(const SystemFunction& derivative,
                        const Eigen::VectorXd& state,
                        const Eigen::VectorXd& inputs);

// x with f = 0 near `guess`, for the path inputs `inputs` (q).
// FailedPrecondition if the iteration does not come to rest: |f_i| ≤ 1e-9 max_k
// |∂f_i/∂x_k| max(|x_k|, 1).
absl::StatusOr<Eigen::VectorXd> SolveSteadyState(
    const SystemFunction& derivative, const Eigen::VectorXd& inputs,
    Eigen::VectorXd guess);

}  // namespace mle::sim

#endif  // SIM_STEADY_STATE_H_
