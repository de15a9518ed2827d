#include "sim/held_input_map.h"

#include <cmath>

#include "gtest/gtest.h"
#include "sim/runge_kutta.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct System {
  MatrixXd A = (MatrixXd(2, 2) << -1.2, -0.8, 1.0, 0.0).finished();
  VectorXd B = (VectorXd(2) << 1.0, 0.0).finished();
};

VectorXd Apply(const HeldInputMap& map, const VectorXd& x, double u) {
  return x + map.E * x + map.gamma * u;
}

TEST(HeldInputMapTest, EqualsTheStepsMadeOneByOne) {
  const System system;
  const double u = 1.7;
  const auto derivative = [&](const VectorXd& x, VectorXd& dx) {
    dx = system.A * x + system.B * u;
  };
  for (const int steps : {1, 2, 3, 7, 64, 100}) {
    VectorXd x = (VectorXd(2) << 0.4, -1.1).finished();
    const HeldInputMap map =
        HeldInputMap::ByRungeKutta4(system.A, system.B, 2.5, steps);
    const VectorXd composed = Apply(map, x, u);
    RungeKutta4<VectorXd> scheme(x);
    for (int i = 0; i < steps; ++i) scheme.Step(derivative, 2.5 / steps, x);
    // A hundred steps of values of order 1: rounding alone.
    EXPECT_LT((composed - x).norm(), 1e-14) << steps << " steps";
  }
}

TEST(HeldInputMapTest, ComposesInOrder) {
  const System system;
  const HeldInputMap first =
      HeldInputMap::ByRungeKutta4(system.A, system.B, 0.5, 3);
  const HeldInputMap second =
      HeldInputMap::ByRungeKutta4(2.0 * system.A, system.B, 1.0, 5);
  const VectorXd x = (VectorXd(2) << 1.0, 2.0).finished();
  EXPECT_LT((Apply(first.Then(second), x, 0.3) -
             Apply(second, Apply(first, x, 0.3), 0.3))
                .norm(),
            1e-15);
}

TEST(HeldInputMapTest, LeavesTheStateAloneOverNoTime) {
  const System system;
  const HeldInputMap map =
      HeldInputMap::ByRungeKutta4(system.A, system.B, 0.0, 4);
  EXPECT_EQ(map.E.norm(), 0.0);
  EXPECT_EQ(map.gamma.norm(), 0.0);
}

// Modes six decades apart, over one time constant of the slow one in 10⁸ steps:
// had Φ been kept instead of Φ − I, rounding would cost the slow mode half of
// its digits.
TEST(HeldInputMapTest, KeepsTheSlowModeOfAStiffSystem) {
  MatrixXd A = MatrixXd::Zero(2, 2);
  A.diagonal() << -1.0, -1e6;
  const VectorXd B = VectorXd::Ones(2);
  const HeldInputMap map = HeldInputMap::ByRungeKutta4(A, B, 1.0, 100'000'000);
  // The scheme's own error is (1e-8)⁴; what is left is the rounding of 27
  // squarings.
  EXPECT_NEAR(map.E(0, 0), std::expm1(-1.0), 1e-13);
  EXPECT_NEAR(map.gamma[0], -std::expm1(-1.0), 1e-13);
  EXPECT_NEAR(map.E(1, 1), -1.0, 1e-13);
  EXPECT_NEAR(map.gamma[1], 1e-6, 1e-6 * 1e-9);
}

}  // namespace
}  // namespace mle::sim
