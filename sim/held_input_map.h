// What a linear system does over an interval in which its input is held:
//
//   ẋ = A x + B u:   x ← x + E x + Γ u.
//
// The map is that of n equal Runge–Kutta steps. A step is linear in (x, u), so
// the n of them are composed once, by repeated squaring, and an interval costs
// one matrix-vector product however fine the steps are. E = Φ − I is kept
// instead of Φ, because in fine steps Φ loses the slow modes to rounding.

#ifndef SIM_HELD_INPUT_MAP_H_
#define SIM_HELD_INPUT_MAP_H_

#include <cstdint>

#include "Eigen/Core"

namespace mle::sim {

struct HeldInputMap {
  Eigen::MatrixXd E;      // r × r
  Eigen::VectorXd gamma;  // r

  // `interval` ≥ 0 in `steps` ≥ 1 steps, for A: r × r, B: r, r ≥ 1.
  static HeldInputMap ByRungeKutta4(const Eigen::MatrixXd& A,
                                    const Eigen::VectorXd& B, double interval,
                                    std::int64_t steps);

  // First this map, then `next`, under the same input.
  HeldInputMap Then(const HeldInputMap& next) const;
};

}  // namespace mle::sim

#endif  // SIM_HELD_INPUT_MAP_H_
