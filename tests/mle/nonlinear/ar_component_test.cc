#include "mle/nonlinear/ar_component.h"

#include <cmath>
#include <complex>

#include "Eigen/Core"
#include "Eigen/LU"
#include "absl/strings/str_format.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::Matrix2d;

struct Case {
  double pole;
  double damping;
};

class ArComponentTest : public ::testing::TestWithParam<Case> {
 protected:
  ArComponentTest() : ar_(GetParam().pole, GetParam().damping) {}

  Matrix2d Transition(int steps) const {
    const ArComponent::Power power = ar_.After(steps);
    Matrix2d F;
    F << power.own, power.cross, ar_.spread() * power.cross, power.own;
    return F;
  }

  ArComponent ar_;
};

// Its poles are those of the definition.
TEST_P(ArComponentTest, Poles) {
  const double omega = -std::log(GetParam().pole);
  const std::complex<double> zeta = GetParam().damping;
  const std::complex<double> root = std::sqrt(zeta * zeta - 1.0);
  const std::complex<double> p1 = std::exp(-omega * (zeta + root));
  const std::complex<double> p2 = std::exp(-omega * (zeta - root));
  EXPECT_NEAR(Transition(1).trace(), (p1 + p2).real(), 1e-14);
  EXPECT_NEAR(Transition(1).determinant(), (p1 * p2).real(), 1e-14);
}

TEST_P(ArComponentTest, PowersAreProducts) {
  Matrix2d product = Matrix2d::Identity();
  for (int steps = 0; steps <= 13; ++steps) {
    EXPECT_LT((Transition(steps) - product).norm(), 1e-13) << steps;
    product *= Transition(1);
  }
}

// P = F P Fᵀ + diag(0, 1).
TEST_P(ArComponentTest, IsStationary) {
  const ArComponent::Covariance unit = ar_.Stationary();
  Matrix2d P;
  P << unit.aa, unit.ab, unit.ab, unit.bb;
  const Matrix2d next = Transition(1) * P * Transition(1).transpose() +
                        Matrix2d{{0.0, 0.0}, {0.0, 1.0}};
  // Digits go where both poles are near 1: P is 1e6 times the shocks there.
  EXPECT_LT((next - P).norm(), 1e-10 * P.norm());
  EXPECT_GT(P.determinant(), 0.0);
}

// Drawn from the start on: the variance is the stationary one. Its estimate
// from 4,000 independent starts has a relative deviation of 0.022; four of it.
TEST_P(ArComponentTest, SignalsHaveTheVariance) {
  GaussianNoise random(1, 2);
  double first = 0.0;
  double later = 0.0;
  const int starts = 4000;
  for (int i = 0; i < starts; ++i) {
    ArSignal signal(ar_, 0.3, random);
    first += signal.value() * signal.value();
    for (int k = 0; k < 3; ++k) signal.Advance();
    later += signal.value() * signal.value();
  }
  const double variance = 0.3 * ar_.Stationary().aa;
  EXPECT_NEAR(first / starts / variance, 1.0, 0.09);
  EXPECT_NEAR(later / starts / variance, 1.0, 0.09);
}

INSTANTIATE_TEST_SUITE_P(Dampings, ArComponentTest,
                         ::testing::Values(Case{0.8, 0.1}, Case{0.9, 1.0},
                                           Case{0.9, 4.0}, Case{0.99, 1.5},
                                           Case{0.3, 0.7}),
                         [](const auto& test) {
                           return absl::StrFormat("Pole%.0fDamping%.0f",
                                                  100.0 * test.param.pole,
                                                  100.0 * test.param.damping);
                         });

TEST(ArComponentTest, FirstOrder) {
  const ArComponent ar(0.9);
  EXPECT_EQ(ar.order(), 1);
  EXPECT_EQ(ar.After(1).own, 0.9);
  EXPECT_NEAR(ar.After(3).own, 0.729, 1e-15);
  EXPECT_NEAR(ar.Stationary().aa, 1.0 / 0.19, 1e-12);
  GaussianNoise random(1, 2);
  double squares = 0.0;
  ArSignal signal(ar, 0.19, random);
  for (int k = 0; k < 100000; ++k, signal.Advance()) {
    squares += signal.value() * signal.value();
  }
  // Correlated over 19 samples: a deviation of √(2 · 9.5/1e5) = 0.014.
  EXPECT_NEAR(squares / 100000, 1.0, 0.06);
}

}  // namespace
}  // namespace mle
