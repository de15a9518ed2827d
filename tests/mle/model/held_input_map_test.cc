#include "mle/model/held_input_map.h"

#include <cmath>

#include "gtest/gtest.h"
#include "sim/runge_kutta.h"

namespace mle {
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

TEST(HeldInputMapTest, OneStateIsTheClosedForm) {
  for (const double rate : {-1e-12, -1e-3, -0.7, -40.0, -1e30, 0.3}) {
    const HeldInputMap map = HeldInputMap::Over(
        1.5, MatrixXd::Constant(1, 1, rate), VectorXd::Constant(1, 2.0));
    const double E = std::expm1(1.5 * rate);
    EXPECT_NEAR(map.E(0, 0), E, 1e-14 * std::abs(E)) << rate;
    const double gamma = 2.0 * E / rate;
    EXPECT_NEAR(map.gamma(0), gamma, 1e-14 * gamma) << rate;
  }
}

// An integration in 2000 steps of fourth order: (1/800)⁴ of the result.
TEST(HeldInputMapTest, AgreesWithAnIntegration) {
  const System system;
  const double u = 1.7;
  const auto derivative = [&](const VectorXd& x, VectorXd& dx) {
    dx = system.A * x + system.B * u;
  };
  VectorXd x = (VectorXd(2) << 0.4, -1.1).finished();
  const VectorXd mapped =
      Apply(HeldInputMap::Over(2.5, system.A, system.B), x, u);
  sim::RungeKutta4<VectorXd> scheme(x);
  for (int i = 0; i < 2000; ++i) scheme.Step(derivative, 2.5 / 2000, x);
  EXPECT_LT((mapped - x).norm(), 1e-12);
}

TEST(HeldInputMapTest, ATimeIsTheSumOfItsParts) {
  const System system;
  const VectorXd x = (VectorXd(2) << 1.0, 2.0).finished();
  const HeldInputMap first = HeldInputMap::Over(0.3, system.A, system.B);
  const HeldInputMap second = HeldInputMap::Over(20.2, system.A, system.B);
  const VectorXd whole =
      Apply(HeldInputMap::Over(20.5, system.A, system.B), x, 0.3);
  EXPECT_LT((Apply(second, Apply(first, x, 0.3), 0.3) - whole).norm(), 1e-14);
}

TEST(HeldInputMapTest, LeavesTheStateAloneOverNoTime) {
  const System system;
  const HeldInputMap map = HeldInputMap::Over(0.0, system.A, system.B);
  EXPECT_EQ(map.E.norm(), 0.0);
  EXPECT_EQ(map.gamma.norm(), 0.0);
}

// Modes far apart, over one time constant of the slow one: had e^{Aτ} been kept
// instead of E, rounding would cost the slow mode as many digits as lie between
// them.
TEST(HeldInputMapTest, KeepsTheSlowModeOfAStiffSystem) {
  for (const double fast : {1e6, 1e12}) {
    MatrixXd A = MatrixXd::Zero(2, 2);
    A.diagonal() << -1.0, -fast;
    const HeldInputMap map = HeldInputMap::Over(1.0, A, VectorXd::Ones(2));
    EXPECT_NEAR(map.E(0, 0), std::expm1(-1.0), 1e-14);
    EXPECT_NEAR(map.gamma[0], -std::expm1(-1.0), 1e-14);
    EXPECT_NEAR(map.E(1, 1), -1.0, 1e-14);
    EXPECT_NEAR(map.gamma[1], 1.0 / fast, 1e-14 / fast);
  }
}

// 1e300 · 1e300 is above the range of doubles, e to the minus that is 0.
TEST(HeldInputMapTest, SettlesOverATimeBeyondTheRange) {
  const HeldInputMap map = HeldInputMap::Over(
      1e300, MatrixXd::Constant(1, 1, -1e300), VectorXd::Ones(1));
  EXPECT_NEAR(map.E(0, 0), -1.0, 1e-12);
  EXPECT_NEAR(map.gamma(0), 1e-300, 1e-312);
}

TEST(HeldInputMapTest, IsNotFiniteWhereASumsToInfinity) {
  const HeldInputMap map = HeldInputMap::Over(
      1.0, MatrixXd::Constant(2, 2, -1.5e308), VectorXd::Ones(2));
  EXPECT_FALSE(map.E.allFinite());
  EXPECT_FALSE(map.gamma.allFinite());
}

TEST(SampleMapTest, IsItsTwoPartsAfterEachOther) {
  const System system;
  const VectorXd x = (VectorXd(2) << 1.0, 2.0).finished();
  for (const double fraction : {0.0, 0.3, 1.0}) {
    const SampleMap map = SampleMap::Over(2.5, fraction, system.A, system.B);
    const VectorXd first =
        Apply(HeldInputMap::Over(fraction * 2.5, system.A, system.B), x, 0.7);
    const VectorXd both =
        Apply(HeldInputMap::Over((1.0 - fraction) * 2.5, system.A, system.B),
              first, -1.1);
    EXPECT_LT((x + map.E * x + map.older * 0.7 - map.newer * 1.1 - both).norm(),
              1e-15)
        << fraction;
  }
}

}  // namespace
}  // namespace mle
