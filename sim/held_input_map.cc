#include "sim/held_input_map.h"

#include "glog/logging.h"
#include "sim/runge_kutta.h"

namespace mle::sim {

HeldInputMap HeldInputMap::ByRungeKutta4(const Eigen::MatrixXd& A,
                                         const Eigen::VectorXd& B,
                                         double interval, std::int64_t steps) {
  CHECK_GE(steps, 1);
  const Eigen::Index r = A.rows();
  // r + 1 trajectories: from each unit vector without input, and from rest
  // under a unit input.
  Eigen::MatrixXd start = Eigen::MatrixXd::Identity(r, r + 1);
  const auto derivative = [&A, &B, r](const Eigen::MatrixXd& x,
                                      Eigen::MatrixXd& dx) {
    dx.noalias() = A * x;
    dx.col(r) += B;
  };
  RungeKutta4<Eigen::MatrixXd> scheme(start);
  const Eigen::MatrixXd& increment = scheme.Increment(
      derivative, interval / static_cast<double>(steps), start);

  HeldInputMap power{increment.leftCols(r), increment.col(r)};
  HeldInputMap map{Eigen::MatrixXd::Zero(r, r), Eigen::VectorXd::Zero(r)};
  for (std::int64_t left = steps; left > 0; left /= 2) {
    if (left % 2 == 1) map = map.Then(power);
    if (left > 1) power = power.Then(power);
  }
  return map;
}

HeldInputMap HeldInputMap::Then(const HeldInputMap& next) const {
  return {E + next.E + next.E * E, gamma + next.gamma + next.E * gamma};
}

}  // namespace mle::sim
