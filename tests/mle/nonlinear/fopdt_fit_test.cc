#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/model/transfer_function.h"
#include "mle/nonlinear/low_order_fit.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kSampleTime = 0.2;
constexpr int kSamples = 501;
constexpr double kHorizon = 100.0;

struct Element {
  double gain;
  double time_constant;
  double delay;

  Eigen::VectorXd Response() const {
    return TransferFunction::FirstOrder(gain, time_constant, delay)
        .StepResponse(kSampleTime, kSamples);
  }
};

FopdtFit Fit(const Eigen::VectorXd& response) {
  const auto fit = FitFopdt(response, kSampleTime, FopdtOptions());
  EXPECT_TRUE(fit.ok()) << fit.status();
  return *fit;
}

double Cost(const Element& element, const Eigen::VectorXd& response) {
  return (element.Response() - response).squaredNorm();
}

Element Of(const FopdtFit& fit) {
  return {fit.gain, fit.time_constant, fit.delay};
}

// Time constants from min_time to max_time; a third of the dead times on the
// samples, a tenth zero.
Element RandomElement(std::mt19937& engine, double min_time, double max_time) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Element element;
  element.gain = std::exp(6.0 * uniform(engine) - 3.0);
  if (uniform(engine) < 0.5) element.gain = -element.gain;
  element.time_constant =
      min_time * std::pow(max_time / min_time, uniform(engine));
  element.delay = 40.0 * uniform(engine);
  const double kind = uniform(engine);
  if (kind < 0.33) {
    element.delay = kSampleTime * std::round(element.delay / kSampleTime);
  }
  if (kind < 0.1) element.delay = 0.0;
  return element;
}

Eigen::VectorXd WithNoise(const Eigen::VectorXd& response, double deviation,
                          std::mt19937& engine) {
  std::normal_distribution<double> normal(0.0, deviation);
  Eigen::VectorXd noisy = response;
  for (int k = 1; k < noisy.size(); ++k) noisy(k) += normal(engine);
  return noisy;
}

TEST(FopdtFitTest, RecoversExactResponses) {
  std::mt19937 engine(1);
  // From a fifth of a sample to five horizons.
  for (int trial = 0; trial < 300; ++trial) {
    const Element truth = RandomElement(engine, 0.04, 5.0 * kHorizon);
    const FopdtFit fit = Fit(truth.Response());
    // The worst conditioned of these (T five horizons, K/T all but alone
    // visible) loses four of sixteen digits.
    EXPECT_NEAR(fit.gain / truth.gain, 1.0, 1e-8);
    EXPECT_NEAR(fit.time_constant / truth.time_constant, 1.0, 1e-8);
    EXPECT_NEAR(fit.delay, truth.delay, 1e-8);
    EXPECT_EQ(fit.shape, FopdtShape::kFits);
    EXPECT_EQ(fit.termination, FopdtTermination::kConverged);
    EXPECT_LT(fit.relative_rms, 1e-10);
  }
}

TEST(FopdtFitTest, RecoversTheWoodBerryColumn) {
  const Element elements[] = {{12.8, 16.7, 1.0},  {-18.9, 21.0, 3.0},
                              {6.6, 10.9, 7.0},   {-19.4, 14.4, 3.0},
                              {-18.9, 21.0, 7.0}, {-18.9, 21.0, 7.1}};
  for (const Element& truth : elements) {
    const FopdtFit fit = Fit(truth.Response());
    EXPECT_NEAR(fit.gain, truth.gain, 1e-9);
    EXPECT_NEAR(fit.time_constant, truth.time_constant, 1e-9);
    EXPECT_NEAR(fit.delay, truth.delay, 1e-9);
  }
}

TEST(FopdtFitTest, NoiseDoesNotTrapItInALocalMinimum) {
  std::mt19937 engine(2);
  for (const double relative_noise : {1e-3, 1e-2, 3e-2}) {
    for (int trial = 0; trial < 150; ++trial) {
      const Element truth = RandomElement(engine, 0.04, 5.0 * kHorizon);
      const Eigen::VectorXd exact = truth.Response();
      const double noise = relative_noise * exact.cwiseAbs().maxCoeff();
      const Eigen::VectorXd noisy = WithNoise(exact, noise, engine);
      const FopdtFit fit = Fit(noisy);
      // The truth is a candidate, so that the minimum cannot lie above it.
      EXPECT_LE(Cost(Of(fit), noisy), Cost(truth, noisy) * (1.0 + 1e-9))
          << truth.gain << " " << truth.time_constant << " " << truth.delay;
    }
  }
}

TEST(FopdtFitTest, NoPointOfADenseGridIsBetter) {
  std::mt19937 engine(3);
  for (int trial = 0; trial < 4; ++trial) {
    const Element truth = RandomElement(engine, 1.0, kHorizon);
    const Eigen::VectorXd noisy =
        WithNoise(truth.Response(), 0.05 * std::abs(truth.gain), engine);
    const double cost = Cost(Of(Fit(noisy)), noisy);
    for (double time = 0.2; time < 1000.0; time *= 1.1) {
      for (double delay = 0.0; delay < 60.0; delay += 0.33) {
        const Eigen::VectorXd unit = Element{1.0, time, delay}.Response();
        const double gain = unit.dot(noisy) / unit.squaredNorm();
        ASSERT_LE(cost, Cost({gain, time, delay}, noisy)) << time << delay;
      }
    }
  }
}

TEST(FopdtFitTest, NoSmallChangeIsBetter) {
  std::mt19937 engine(4);
  for (int trial = 0; trial < 20; ++trial) {
    const Element truth = RandomElement(engine, 1.0, kHorizon);
    const Eigen::VectorXd noisy =
        WithNoise(truth.Response(), 0.01 * std::abs(truth.gain), engine);
    const Element fit = Of(Fit(noisy));
    const double cost = Cost(fit, noisy);
    for (const double change : {1e-3, -1e-3, 1e-5, -1e-5}) {
      Element other = fit;
      other.gain *= 1.0 + change;
      EXPECT_GT(Cost(other, noisy), cost);
      other = fit;
      other.time_constant *= 1.0 + change;
      EXPECT_GT(Cost(other, noisy), cost);
      other = fit;
      other.delay = std::max(0.0, fit.delay + change);
      // Only a dead time of 0 leaves nothing to change.
      if (other.delay != fit.delay) {
        EXPECT_GT(Cost(other, noisy), cost);
      }
    }
  }
}

TEST(FopdtFitTest, StandardErrorsAreThoseOfManyFits) {
  std::mt19937 engine(5);
  const Element truth = {-18.9, 21.0, 7.1};
  const int trials = 400;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (int trial = 0; trial < trials; ++trial) {
    const FopdtFit fit = Fit(WithNoise(truth.Response(), 0.2, engine));
    const Eigen::Vector3d scores(
        (fit.gain - truth.gain) / fit.gain_standard_error,
        (fit.time_constant - truth.time_constant) /
            fit.time_constant_standard_error,
        (fit.delay - truth.delay) / fit.delay_standard_error);
    squares += scores.cwiseAbs2();
  }
  // A mean of 400 squared normal scores has the standard deviation
  // √(2/400) = 0.07 around 1; four of them.
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(squares(i) / trials, 1.0, 0.28) << i;
  }
}

TEST(FopdtFitTest, WigglesMoveItLittle) {
  // As the response of a corrected ARX model: 0.5 % of slow oscillation.
  const Element truth = {-19.4, 14.4, 7.0};
  Eigen::VectorXd response = truth.Response();
  for (int k = 36; k < kSamples; ++k) {
    response(k) += 0.1 * std::sin(0.21 * k) + 0.05 * std::sin(1.3 * k);
  }
  const FopdtFit fit = Fit(response);
  EXPECT_EQ(fit.shape, FopdtShape::kFits);
  // The oscillation averages out over its many periods; what is left is below
  // its own size.
  EXPECT_NEAR(fit.gain, truth.gain, 0.05);
  EXPECT_NEAR(fit.time_constant, truth.time_constant, 0.3);
  EXPECT_NEAR(fit.delay, truth.delay, 0.1);
}

TEST(FopdtFitTest, UnitsDoNotMatter) {
  std::mt19937 engine(6);
  const Element truth = {3.0, 8.0, 2.3};
  const Eigen::VectorXd noisy = WithNoise(truth.Response(), 0.03, engine);
  const FopdtFit fit = Fit(noisy);
  const auto other = FitFopdt(-1e-4 * noisy, 60.0 * kSampleTime, {});
  ASSERT_TRUE(other.ok());
  EXPECT_NEAR(other->gain / fit.gain, -1e-4, 1e-12);
  EXPECT_NEAR(other->time_constant / fit.time_constant, 60.0, 1e-6);
  EXPECT_NEAR(other->delay / fit.delay, 60.0, 1e-6);
  EXPECT_NEAR(other->delay_standard_error / fit.delay_standard_error, 60.0,
              1e-6);
  EXPECT_NEAR(other->relative_rms, fit.relative_rms, 1e-9);
}

TEST(FopdtFitTest, NoResponseIsSaidSo) {
  for (const double rounding : {0.0, 1e-13}) {
    std::mt19937 engine(7);
    const FopdtFit fit =
        Fit(WithNoise(Eigen::VectorXd::Zero(kSamples), rounding, engine));
    EXPECT_EQ(fit.shape, FopdtShape::kNoResponse);
    EXPECT_EQ(fit.gain, 0.0);
    EXPECT_EQ(fit.time_constant, 0.0);
    EXPECT_EQ(fit.delay, 0.0);
  }
}

TEST(FopdtFitTest, OtherShapesArePoorFits) {
  std::mt19937 engine(8);
  Eigen::VectorXd ramp(kSamples);
  Eigen::VectorXd growth(kSamples);
  for (int k = 0; k < kSamples; ++k) {
    ramp(k) = 0.03 * std::max(0, k - 20);
    growth(k) = std::expm1(0.02 * k);
  }
  const auto response = [](std::vector<double> b, std::vector<double> a) {
    return TransferFunction(b, a, 2.0).StepResponse(kSampleTime, kSamples);
  };
  const struct {
    const char* name;
    Eigen::VectorXd response;
  } cases[] = {
      {"integrating", ramp},
      {"unstable", growth},
      {"unstable, saturated", (1e90 * growth).cwiseMin(1e92)},
      {"inverse response", response({-6.0, 1.0}, {6.0, 5.0, 1.0})},
      {"oscillating", response({1.0}, {1.0, 0.2, 1.0})},
      {"overshoot", response({20.0, 1.0}, {30.0, 13.0, 1.0})},
      {"noise", WithNoise(Eigen::VectorXd::Zero(kSamples), 1.0, engine)},
  };
  for (const auto& c : cases) {
    const FopdtFit fit = Fit(c.response);
    EXPECT_EQ(fit.shape, FopdtShape::kPoorFit) << c.name;
    EXPECT_TRUE(std::isfinite(fit.gain)) << c.name;
    EXPECT_TRUE(std::isfinite(fit.relative_rms)) << c.name;
    EXPECT_GE(fit.delay, 0.0) << c.name;
  }
}

TEST(FopdtFitTest, SecondOrderLagFits) {
  const FopdtFit fit = Fit(TransferFunction({2.0}, {48.0, 16.0, 1.0}, 1.0)
                               .StepResponse(kSampleTime, kSamples));
  EXPECT_EQ(fit.shape, FopdtShape::kFits);
  EXPECT_NEAR(fit.gain, 2.0, 0.02);
  // The area above the response is 4 + 12 + 1; the fit weighs squares, not
  // areas, and so comes within 5 % of it only.
  EXPECT_NEAR(fit.time_constant + fit.delay, 17.0, 0.85);
}

TEST(FopdtFitTest, JumpHasItsGainAndNoTimeConstant) {
  Eigen::VectorXd jump = Eigen::VectorXd::Zero(kSamples);
  jump.tail(kSamples - 50).setConstant(-4.0);
  const FopdtFit fit = Fit(jump);
  EXPECT_EQ(fit.shape, FopdtShape::kFits);
  EXPECT_NEAR(fit.gain, -4.0, 1e-6);
  EXPECT_LT(fit.time_constant, kSampleTime);
  EXPECT_GE(fit.delay, 49 * kSampleTime - 1e-9);
  EXPECT_LE(fit.delay, 50 * kSampleTime);
  EXPECT_FALSE(std::isnan(fit.gain_standard_error));
  EXPECT_FALSE(std::isnan(fit.time_constant_standard_error));
  EXPECT_FALSE(std::isnan(fit.delay_standard_error));
}

TEST(FopdtFitTest, DeadTimeStaysWithinItsBound) {
  const Element truth = {2.0, 10.0, 6.1};
  FopdtOptions options;
  for (const double bound : {0.0, 0.07, 1.0, 5.95, 6.05}) {
    options.max_delay = bound;
    const auto fit = FitFopdt(truth.Response(), kSampleTime, options);
    ASSERT_TRUE(fit.ok());
    // The bound is active: the sum of squares falls all the way to 6.1.
    EXPECT_NEAR(fit->delay, bound, 1e-9);
    EXPECT_NE(fit->termination, FopdtTermination::kFailed) << bound;
  }
  options.max_delay = 6.1;
  EXPECT_NEAR(FitFopdt(truth.Response(), kSampleTime, options)->delay, 6.1,
              1e-9);
}

TEST(FopdtFitTest, FewSamplesAreEnoughWhenExact) {
  const Element truth = {1.5, 0.4, 0.1};
  const Eigen::VectorXd response = truth.Response().head(8);
  const auto fit = FitFopdt(response, kSampleTime, FopdtOptions());
  ASSERT_TRUE(fit.ok());
  EXPECT_NEAR(fit->gain, 1.5, 1e-9);
  EXPECT_NEAR(fit->time_constant, 0.4, 1e-9);
  EXPECT_NEAR(fit->delay, 0.1, 1e-9);
}

TEST(FopdtFitTest, SaysWhatIsWrongWithTheResponse) {
  const auto message = [](const Eigen::VectorXd& response, double dt) {
    return std::string(
        FitFopdt(response, dt, FopdtOptions()).status().message());
  };
  Eigen::VectorXd response = Element{1.0, 2.0, 0.5}.Response();
  EXPECT_THAT(message(response, 0.0), HasSubstr("sample_time is 0"));
  EXPECT_THAT(message(response.head(4), 0.2), HasSubstr("has 4 samples"));
  response(17) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(response, 0.2), HasSubstr("sample 17"));
}

TEST(FopdtOptionsTest, ValidateNamesTheField) {
  const auto message = [](auto change) {
    FopdtOptions options;
    EXPECT_TRUE(options.Validate().ok());
    change(options);
    return std::string(options.Validate().message());
  };
  EXPECT_THAT(message([](FopdtOptions& o) { o.max_delay = -1.0; }),
              HasSubstr("max_delay is -1"));
  EXPECT_THAT(message([](FopdtOptions& o) { o.max_delay = kNaN; }),
              HasSubstr("max_delay is nan"));
  EXPECT_THAT(
      message([](FopdtOptions& o) { o.min_time_constant_samples = 0.0; }),
      HasSubstr("min_time_constant_samples is 0"));
  EXPECT_THAT(
      message([](FopdtOptions& o) { o.max_time_constant_horizons = 0.5; }),
      HasSubstr("max_time_constant_horizons is 0.5"));
  EXPECT_THAT(message([](FopdtOptions& o) { o.negligible_response = -1.0; }),
              HasSubstr("negligible_response"));
  EXPECT_THAT(message([](FopdtOptions& o) { o.poor_relative_rms = 0.0; }),
              HasSubstr("poor_relative_rms"));
  EXPECT_THAT(message([](FopdtOptions& o) { o.poor_relative_residual = kNaN; }),
              HasSubstr("poor_relative_residual"));
  EXPECT_THAT(message([](FopdtOptions& o) { o.num_starts = 0; }),
              HasSubstr("num_starts is 0"));
  EXPECT_THAT(message([](FopdtOptions& o) { o.max_iterations = 0; }),
              HasSubstr("max_iterations is 0"));
}

TEST(FopdtFitTest, StartsPessimistic) {
  EXPECT_EQ(FopdtFit().shape, FopdtShape::kPoorFit);
  EXPECT_EQ(FopdtFit().termination, FopdtTermination::kNotRun);
}

}  // namespace
}  // namespace mle
