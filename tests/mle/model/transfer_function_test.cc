#include "mle/model/transfer_function.h"

#include <cmath>
#include <string>
#include <vector>

#include "Eigen/LU"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

std::string Message(const TransferFunction& g) {
  return std::string(g.Validate().message());
}

// Coefficients of Π (s + rates[i]).
std::vector<double> FromRates(const std::vector<double>& rates) {
  std::vector<double> polynomial = {1.0};
  for (const double rate : rates) {
    polynomial.push_back(0.0);
    for (std::size_t i = polynomial.size() - 1; i > 0; --i) {
      polynomial[i] += rate * polynomial[i - 1];
    }
  }
  return polynomial;
}

// 1 / Π (s + a_i) with distinct a_i at t, by partial fractions.
double DistinctRates(const std::vector<double>& rates, double t) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    double residue = 1.0;
    for (std::size_t j = 0; j < rates.size(); ++j) {
      if (j != i) residue /= rates[j] - rates[i];
    }
    sum -= residue / rates[i] * std::expm1(-rates[i] * t);
  }
  return sum;
}

// A settling time of five time constants and more is a number still.
TEST(TransferFunctionTest, TimesBeyondNumbersAreRefused) {
  EXPECT_TRUE(TransferFunction::FirstOrder(1.0, 1e299, 0.0).Validate().ok());
  EXPECT_TRUE(TransferFunction::FirstOrder(1.0, 1.0, 1e299).Validate().ok());
  for (const TransferFunction& g :
       {TransferFunction::FirstOrder(1.0, 1e301, 0.0),
        TransferFunction::FirstOrder(1.0, 1.0, 1e308)}) {
    EXPECT_THAT(Message(g),
                HasSubstr("delay and slowest time constant are together"));
  }
}

TEST(TransferFunctionTest, DefaultIsZero) {
  const TransferFunction g;
  EXPECT_TRUE(g.Validate().ok());
  EXPECT_TRUE(g.IsZero());
  EXPECT_FALSE(g.IsFirstOrder());
  EXPECT_EQ(g.StaticGain(), 0.0);
  EXPECT_EQ(g.SlowestTimeConstant(), 0.0);
  EXPECT_TRUE(g.StepResponse(0.2, 10).isZero(0.0));
}

TEST(TransferFunctionTest, FirstOrderKeepsItsParameters) {
  const auto g = TransferFunction::FirstOrder(12.8, 16.7, 1.0);
  EXPECT_TRUE(g.Validate().ok());
  EXPECT_TRUE(g.IsFirstOrder());
  EXPECT_FALSE(g.IsZero());
  EXPECT_EQ(g.StaticGain(), 12.8);
  EXPECT_EQ(g.TimeConstant(), 16.7);
  EXPECT_EQ(g.SlowestTimeConstant(), 16.7);
  EXPECT_EQ(g.delay(), 1.0);
}

TEST(TransferFunctionTest, LeadingZerosDoNotCount) {
  const TransferFunction g({0.0, 0.0, 6.0}, {0.0, 4.0, 2.0}, 0.5);
  EXPECT_TRUE(g.Validate().ok());
  EXPECT_TRUE(g.IsFirstOrder());
  EXPECT_EQ(g.StaticGain(), 3.0);
  EXPECT_EQ(g.TimeConstant(), 2.0);
  EXPECT_THAT(g.denominator(), ::testing::ElementsAre(4.0, 2.0));
}

TEST(TransferFunctionTest, ValidateSaysWhatIsWrong) {
  EXPECT_THAT(Message(TransferFunction({1.0}, {0.0, 0.0}, 0.0)),
              HasSubstr("denominator is zero"));
  EXPECT_THAT(Message(TransferFunction({1.0}, {}, 0.0)),
              HasSubstr("denominator is zero"));
  EXPECT_THAT(Message(TransferFunction({1.0, 0.0, 1.0}, {1.0, 1.0}, 0.0)),
              HasSubstr("proper"));
  EXPECT_THAT(Message(TransferFunction({NAN}, {1.0, 1.0}, 0.0)),
              HasSubstr("numerator [nan]"));
  EXPECT_THAT(Message(TransferFunction({1.0}, {kInfinity, 1.0}, 0.0)),
              HasSubstr("denominator [inf, 1]"));
  EXPECT_THAT(Message(TransferFunction::FirstOrder(1.0, 1.0, -0.5)),
              HasSubstr("delay is -0.5"));
  EXPECT_THAT(Message(TransferFunction::FirstOrder(1.0, 1.0, NAN)),
              HasSubstr("delay is nan"));
  EXPECT_THAT(Message(TransferFunction({1.0}, std::vector<double>(60, 1.0), 0)),
              HasSubstr("degree 59"));
  EXPECT_THAT(Message(TransferFunction({1e308}, {1e-308, 1e-300}, 0.0)),
              HasSubstr("overflows"));
  // Its square does: the response of such a lag was none at all.
  EXPECT_THAT(Message(TransferFunction::Integrator(1.0, 1e-300, 1.0)),
              HasSubstr("overflows"));
  EXPECT_TRUE(TransferFunction::Integrator(1.0, 1e-100, 1.0).Validate().ok());
}

TEST(TransferFunctionTest, AnOscillationMustEnd) {
  EXPECT_TRUE(TransferFunction({2.0}, {1.0, 1e-9, 1.0}, 0.0).Validate().ok());
  for (const double small : {1e-30, 1e-150, 1e-300}) {
    EXPECT_THAT(Message(TransferFunction({2.0}, {small, small, 1.0}, 0.0)),
                HasSubstr("has a damping ratio of"));
  }
}

TEST(TransferFunctionTest, ResponsesSettleInTheTimeToSettle) {
  EXPECT_EQ(TransferFunction::FirstOrder(2.0, 4.0, 3.0).TimeToSettle(), 23.0);
  std::vector<double> lags = {1.0};
  for (int n = 1; n <= 12; ++n) {
    lags.push_back(0.0);  // times 3 s + 1
    for (std::size_t i = lags.size() - 1; i > 0; --i) {
      lags[i] = 3.0 * lags[i] + lags[i - 1];
    }
    lags[0] *= 3.0;
    const TransferFunction g({2.0}, lags, 1.0);
    const double time = g.TimeToSettle();
    EXPECT_NEAR(g.StepResponse(time / 100.0, 101)(100), 2.0, 0.02) << n;
    EXPECT_GT(time, 1.0 + 3.0 * n) << n;
  }
}

TEST(TransferFunctionTest, UnstableIsInvalid) {
  const std::vector<std::vector<double>> unstable = {
      {-5.0, 1.0},                // Pole at 0.2.
      {-5.0, 1.0, 0.0},           // And an integrator.
      {1.0, 0.0, 1.0, 0.0},       // Undamped, and an integrator.
      {1.0, -1.0, 1.0},           // Growing oscillation.
      {1.0, 0.0, 1.0},            // Undamped.
      {1.0, 1.0, 1.0, 1.0},       // (s² + 1)(s + 1): all signs agree.
      {1.0, 1.0, 1.0, 2.0},       // Fails Routh: 1·1 < 1·2.
      {1.0, 2.0, 1e6, 2e6},       // (s² + 1e6)(s + 2).
      {1e-12, 1e-9, 1e-6, 2e-3},  // As 1, 1, 1, 2, in another unit.
  };
  for (const auto& denominator : unstable) {
    const TransferFunction g({1.0}, denominator, 0.0);
    EXPECT_THAT(Message(g), HasSubstr("left half-plane"))
        << ::testing::PrintToString(denominator);
  }
}

TEST(TransferFunctionTest, OnePoleAtZeroIsAnIntegrator) {
  const TransferFunction g({4.0, 6.0}, {5.0, 7.0, 2.0, 0.0}, 0.5);
  EXPECT_TRUE(g.Validate().ok()) << g.Validate();
  EXPECT_EQ(g.IntegrationOrder(), 1);
  EXPECT_FALSE(g.IsIntegratorWithLag());
  EXPECT_EQ(g.StaticGain(), 3.0);  // 6/2, a slope.
  // 5 s² + 7 s + 2 = (5 s + 2)(s + 1).
  EXPECT_NEAR(g.SlowestTimeConstant(), 2.5, 1e-12);
  EXPECT_EQ(TransferFunction::FirstOrder(1.0, 2.0, 0.0).IntegrationOrder(), 0);

  const auto pure = TransferFunction::Integrator(-0.4, 0.0, 0.6);
  EXPECT_TRUE(pure.Validate().ok()) << pure.Validate();
  EXPECT_TRUE(pure.IsIntegratorWithLag());
  EXPECT_FALSE(pure.IsFirstOrder());
  EXPECT_EQ(pure.StaticGain(), -0.4);
  EXPECT_EQ(pure.SlowestTimeConstant(), 0.0);
  EXPECT_EQ(pure.Realize().A.size(), 1);

  // Nothing is integrated.
  const auto zero = TransferFunction::Integrator(0.0, 2.0, 0.6);
  EXPECT_TRUE(zero.Validate().ok()) << zero.Validate();
  EXPECT_EQ(zero.IntegrationOrder(), 0);
  EXPECT_EQ(zero.StaticGain(), 0.0);
}

TEST(TransferFunctionTest, MoreThanOnePoleAtZeroIsInvalid) {
  EXPECT_THAT(Message(TransferFunction({1.0}, {1.0, 0.0, 0.0}, 0.0)),
              HasSubstr("more than one pole at s = 0"));
  EXPECT_THAT(Message(TransferFunction({1.0}, {2.0, 1.0, 0.0, 0.0}, 0.0)),
              HasSubstr("more than one pole at s = 0"));
  EXPECT_THAT(Message(TransferFunction({1.0, 0.0}, {2.0, 1.0, 0.0}, 0.0)),
              HasSubstr("cancel the common factor"));
}

// K e^{−Ls}/(s (T s + 1)): K (τ − T (1 − e^{−τ/T})) at τ = t − L.
TEST(TransferFunctionTest, StepResponseOfAnIntegratorEndsInItsRamp) {
  const double K = -0.6, T = 3.0, L = 1.3, dt = 0.5;
  const Eigen::VectorXd with_lag =
      TransferFunction::Integrator(K, T, L).StepResponse(dt, 400);
  const Eigen::VectorXd pure =
      TransferFunction::Integrator(K, 0.0, L).StepResponse(dt, 400);
  for (int k = 0; k < 400; ++k) {
    const double t = std::max(0.0, k * dt - L);
    // Sums of 400 terms, each rounded.
    EXPECT_NEAR(with_lag(k), K * (t + T * std::expm1(-t / T)), 1e-12) << k;
    EXPECT_NEAR(pure(k), K * t, 1e-12) << k;
  }
  EXPECT_NEAR(with_lag(399) - with_lag(398), K * dt, 1e-12);
}

TEST(TransferFunctionTest, StableIsValid) {
  const std::vector<std::vector<double>> stable = {
      {1.0, 1.0},
      {-2.0, -1.0},
      {1.0, 2e-6, 1.0},       // Damping ratio 1e-6.
      {1.0, 1.0, 1.0, 0.99},  // Just within Routh.
      FromRates({1e-4, 1.0, 1e4}),
      FromRates({1e-9, 1e-9, 1e9, 1e9}),
      FromRates({1, 1, 1, 1, 1, 1, 1, 1}),
      FromRates({1e-3, 1e-2, 1e-1, 1, 10, 100, 1000, 1e4}),
  };
  for (const auto& denominator : stable) {
    const TransferFunction g({1.0}, denominator, 0.0);
    EXPECT_TRUE(g.Validate().ok()) << g.Validate();
  }
}

TEST(TransferFunctionTest, SlowestTimeConstantIsThatOfTheSlowestMode) {
  // Simple poles: the eigenvalues of the balanced companion matrix keep the
  // small ones to about 1e-10 here.
  EXPECT_NEAR(TransferFunction({1.0}, FromRates({0.01, 1.0, 100.0}), 0.0)
                  .SlowestTimeConstant(),
              100.0, 1e-7);
  // s² + 0.2 s + 4: real part −0.1.
  EXPECT_NEAR(
      TransferFunction({1.0}, {1.0, 0.2, 4.0}, 0.0).SlowestTimeConstant(), 10.0,
      1e-12);
}

TEST(TransferFunctionTest, RealisationHasTheTransferFunction) {
  const TransferFunction g({2.0, 3.0, 5.0}, {4.0, 7.0, 11.0}, 0.0);
  const StateSpace system = g.Realize();
  for (const double s : {0.0, 0.5, 2.0, 30.0}) {
    const Eigen::MatrixXd resolvent =
        s * Eigen::MatrixXd::Identity(2, 2) - system.A;
    const double value = system.C * resolvent.lu().solve(system.B) + system.D;
    const double expected = (2 * s * s + 3 * s + 5) / (4 * s * s + 7 * s + 11);
    EXPECT_NEAR(value, expected, 1e-14) << s;
  }
}

TEST(StepResponseOfElementTest, FirstOrderIsTheClosedForm) {
  for (const double delay : {0.0, 0.07, 0.2, 3.0, 7.1}) {
    const Eigen::VectorXd h =
        TransferFunction::FirstOrder(-18.9, 21.0, delay).StepResponse(0.2, 501);
    for (int k = 0; k < 501; ++k) {
      const double t = k * 0.2 - delay;
      const double expected = t <= 1e-9 ? 0.0 : 18.9 * std::expm1(-t / 21.0);
      // The time after the dead time is known to 1e-14 of 100.
      ASSERT_NEAR(h(k), expected, 1e-13) << delay << " " << k;
    }
  }
}

TEST(StepResponseOfElementTest, DeadTimeOnASampleIsExactlyZeroThere) {
  // 3 · 0.1 > 0.3 and 7 · 0.1 > 0.7 in doubles.
  for (const int steps : {1, 3, 6, 7, 12, 17, 35}) {
    const Eigen::VectorXd h =
        TransferFunction({1.0, 1.0}, {1.0, 2.0}, steps / 10.0)
            .StepResponse(0.1, 40);
    EXPECT_TRUE(h.head(steps + 1).isZero(0.0)) << steps;
    // Feedthrough 1 shows from the next sample on.
    EXPECT_NEAR(h(steps + 1), 0.5 + 0.5 * std::exp(-0.2), 1e-13) << steps;
  }
}

TEST(StepResponseOfElementTest, DistinctRealPolesMatchPartialFractions) {
  const std::vector<std::vector<double>> cases = {
      {0.05, 0.11}, {0.02, 0.3, 1.7}, {0.1, 0.2, 0.35, 0.6, 1.1}};
  for (const auto& rates : cases) {
    const TransferFunction g({1.0}, FromRates(rates), 0.37);
    const Eigen::VectorXd h = g.StepResponse(0.2, 300);
    for (int k = 0; k < 300; ++k) {
      const double t = k * 0.2 - 0.37;
      // Partial fractions cancel: their terms are up to 1e3 the result.
      const double expected = t <= 0.0 ? 0.0 : DistinctRates(rates, t);
      ASSERT_NEAR(h(k), expected, 1e-11 * g.StaticGain()) << k;
    }
  }
}

TEST(StepResponseOfElementTest, RepeatedPoleMatchesTheClosedForm) {
  // 1/(s + a)³: (1 − e^{−at}(1 + at + (at)²/2)) / a³.
  const double a = 0.4;
  const Eigen::VectorXd h = TransferFunction({1.0}, FromRates({a, a, a}), 1.13)
                                .StepResponse(0.2, 200);
  for (int k = 0; k < 200; ++k) {
    const double x = a * (k * 0.2 - 1.13);
    const double expected =
        x <= 0.0 ? 0.0
                 : (1.0 - std::exp(-x) * (1.0 + x + x * x / 2)) / (a * a * a);
    ASSERT_NEAR(h(k), expected, 1e-12) << k;
  }
}

TEST(StepResponseOfElementTest, OscillationMatchesTheClosedForm) {
  // s² + 2ζω s + ω², unit gain.
  const double w = 0.9;
  const double zeta = 0.15;
  const double damped = w * std::sqrt(1 - zeta * zeta);
  const Eigen::VectorXd h =
      TransferFunction({w * w}, {1.0, 2 * zeta * w, w * w}, 0.05)
          .StepResponse(0.2, 400);
  for (int k = 1; k < 400; ++k) {
    const double t = k * 0.2 - 0.05;
    const double expected =
        1.0 -
        std::exp(-zeta * w * t) *
            (std::cos(damped * t) + zeta * w / damped * std::sin(damped * t));
    // 400 products with the step matrix gather rounding.
    ASSERT_NEAR(h(k), expected, 1e-12) << k;
  }
}

TEST(StepResponseOfElementTest, InverseResponseStartsTheOtherWay) {
  // (1 − 4s)/((3s + 1)(2s + 1)) = 7/(2s + 1)·… by partial fractions:
  // h = 1 + 6 e^{−t/2} − 7 e^{−t/3}.
  const Eigen::VectorXd h = TransferFunction({-4.0, 1.0}, {6.0, 5.0, 1.0}, 0.0)
                                .StepResponse(0.2, 200);
  for (int k = 0; k < 200; ++k) {
    const double t = 0.2 * k;
    ASSERT_NEAR(h(k), 1.0 + 6.0 * std::exp(-t / 2) - 7.0 * std::exp(-t / 3),
                1e-12);
  }
  EXPECT_LT(h(2), 0.0);
}

TEST(StepResponseOfElementTest, StiffPolesStayAccurate) {
  // Rates seven decades apart; the sample is long for the fast one.
  const std::vector<double> rates = {0.05, 5e5};
  const TransferFunction g({0.05 * 5e5}, FromRates(rates), 0.3);
  const Eigen::VectorXd h = g.StepResponse(0.2, 500);
  for (int k = 2; k < 500; ++k) {
    const double t = 0.2 * k - 0.3;
    // The fast mode is over; it has shifted the slow one by 2e-6.
    const double expected = 1.0 - std::exp(-0.05 * t) * 5e5 / (5e5 - 0.05);
    // Backward stable: ε ‖A‖ t = 1e-16 · 5e5 · 100.
    ASSERT_NEAR(h(k), expected, 5e-9) << k;
  }
}

TEST(StepResponseOfElementTest, SettlesAtTheStaticGain) {
  const TransferFunction g({3.0, 1.0, 5.0}, {8.0, 12.0, 6.0, 2.0}, 2.5);
  const Eigen::VectorXd h = g.StepResponse(1.0, 400);
  // 400 products with the step matrix gather rounding.
  EXPECT_NEAR(h(399), g.StaticGain(), 1e-12);
}

TEST(StepResponseOfElementTest, IsLinearInTheNumerator) {
  const std::vector<double> denominator = {2.0, 3.0, 4.0, 1.0};
  const Eigen::VectorXd a =
      TransferFunction({1.0, 0.0, 2.0}, denominator, 0.7).StepResponse(0.2, 99);
  const Eigen::VectorXd b =
      TransferFunction({5.0, 1.0}, denominator, 0.7).StepResponse(0.2, 99);
  const Eigen::VectorXd sum =
      TransferFunction({1.0, 5.0, 3.0}, denominator, 0.7).StepResponse(0.2, 99);
  EXPECT_LT((a + b - sum).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(StepResponseOfElementTest, TimeUnitDoesNotMatter) {
  // Minutes to seconds: s becomes s/60.
  const TransferFunction minutes({2.0, 1.0}, {6.0, 5.0, 1.0, 0.04}, 1.5);
  const double u = 60.0;
  const TransferFunction seconds(
      {2.0 * u, 1.0}, {6.0 * u * u * u, 5.0 * u * u, 1.0 * u, 0.04}, 1.5 * u);
  const Eigen::VectorXd a = minutes.StepResponse(0.2, 500);
  const Eigen::VectorXd b = seconds.StepResponse(12.0, 500);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(StepResponseOfElementTest, StaticElementJumpsAfterTheDeadTime) {
  const Eigen::VectorXd h =
      TransferFunction({6.0}, {2.0}, 0.5).StepResponse(0.25, 6);
  EXPECT_THAT(std::vector<double>(h.begin(), h.end()),
              ::testing::ElementsAre(0, 0, 0, 3, 3, 3));
}

TEST(StepResponseOfElementTest, DeadTimeBeyondTheHorizonIsZero) {
  EXPECT_TRUE(TransferFunction::FirstOrder(1.0, 1.0, 1e300)
                  .StepResponse(0.2, 50)
                  .isZero(0.0));
  EXPECT_EQ(
      TransferFunction::FirstOrder(1.0, 1.0, 0.0).StepResponse(0.2, 0).size(),
      0);
}

}  // namespace
}  // namespace mle
