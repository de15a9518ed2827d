#include "mle/nonlinear/sopdt_fit.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr double kSampleTime = 0.2;
constexpr int kSamples = 501;

VectorXd Lags(double gain, double first, double second, double delay) {
  return TransferFunction({gain}, {first * second, first + second, 1.0}, delay)
      .StepResponse(kSampleTime, kSamples);
}

SopdtFit Fit(const VectorXd& response) {
  const auto fit = FitSopdt(response, kSampleTime, FopdtOptions());
  EXPECT_TRUE(fit.ok()) << fit.status();
  return *fit;
}

TEST(SopdtFitTest, RecoversExactResponses) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> uniform;
  for (int trial = 0; trial < 25; ++trial) {
    const double gain = uniform(engine) < 0.5 ? -18.9 : 0.3;
    const double first = 5.0 + 25.0 * uniform(engine);
    const double second = first * (0.1 + 0.6 * uniform(engine));
    const double delay = 15.0 * uniform(engine);
    const SopdtFit fit = Fit(Lags(gain, first, second, delay));
    // The two time constants trade against each other and the dead time: five
    // of ten digits that the solver's tolerance leaves.
    EXPECT_NEAR(fit.gain / gain, 1.0, 1e-5) << fit.BriefReport();
    EXPECT_NEAR(fit.time_constant / first, 1.0, 1e-4);
    EXPECT_NEAR(fit.second_time_constant / second, 1.0, 1e-4);
    EXPECT_NEAR(fit.delay, delay, 1e-3);
    EXPECT_EQ(fit.shape, FopdtShape::kFits);
    EXPECT_EQ(fit.response, ResponseShape::kSettling);
  }
}

TEST(SopdtFitTest, EqualLagsAreFittedToo) {
  const VectorXd response = Lags(2.0, 6.0, 6.0, 1.1);
  const SopdtFit fit = Fit(response);
  EXPECT_NEAR(fit.gain, 2.0, 1e-3);
  // Their difference enters by its square, so that only their sum is sharp.
  EXPECT_NEAR(fit.time_constant + fit.second_time_constant, 12.0, 0.05);
  EXPECT_LT(fit.relative_rms, 1e-4);
  EXPECT_FALSE(std::isnan(fit.time_constant_standard_error));
}

TEST(SopdtFitTest, StandardErrorsAreThoseOfManyFits) {
  std::mt19937 engine(2);
  std::normal_distribution<double> normal(0.0, 0.02);
  const VectorXd exact = Lags(2.0, 12.0, 4.0, 3.3);
  const int trials = 60;
  Eigen::Vector4d squares = Eigen::Vector4d::Zero();
  for (int trial = 0; trial < trials; ++trial) {
    VectorXd noisy = exact;
    for (int k = 1; k < noisy.size(); ++k) noisy(k) += normal(engine);
    const SopdtFit fit = Fit(noisy);
    squares += Eigen::Vector4d((fit.gain - 2.0) / fit.gain_standard_error,
                               (fit.time_constant - 12.0) /
                                   fit.time_constant_standard_error,
                               (fit.second_time_constant - 4.0) /
                                   fit.second_time_constant_standard_error,
                               (fit.delay - 3.3) / fit.delay_standard_error)
                   .cwiseAbs2();
  }
  // Deviation √(2/60) = 0.18 of the mean of squared normal scores; four.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(squares(i) / trials, 1.0, 0.73) << i;
}

TEST(SopdtFitTest, BeatsFirstOrderOnTwoLags) {
  const VectorXd response = Lags(2.0, 12.0, 8.0, 1.0);
  const auto first = FitFopdt(response, kSampleTime, FopdtOptions());
  ASSERT_TRUE(first.ok());
  EXPECT_LT(Fit(response).relative_rms, 1e-3 * first->relative_rms);
}

TEST(SopdtFitTest, ResponseIsThatOfItsTransferFunction) {
  const VectorXd response = Lags(2.0, 12.0, 8.0, 1.0);
  const VectorXd fitted =
      Fit(response).ToTransferFunction().StepResponse(kSampleTime, kSamples);
  EXPECT_LT((fitted - response).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(ResponseShapeTest, NamesWhatNoLagHas) {
  VectorXd ramp(kSamples);
  for (int k = 0; k < kSamples; ++k) ramp(k) = -0.03 * std::max(0, k - 20);
  const VectorXd inverse = TransferFunction({-6.0, 1.0}, {6.0, 5.0, 1.0}, 2.0)
                               .StepResponse(kSampleTime, kSamples);
  EXPECT_EQ(Fit(ramp).response, ResponseShape::kIntegrating);
  EXPECT_EQ(Fit(ramp).shape, FopdtShape::kPoorFit);
  EXPECT_THAT(Fit(ramp).BriefReport(), HasSubstr("integrating"));
  EXPECT_EQ(Fit(inverse).response, ResponseShape::kInverse);
  EXPECT_EQ(Fit(-inverse).response, ResponseShape::kInverse);
  EXPECT_EQ(Fit(inverse).shape, FopdtShape::kPoorFit);
  const SopdtFit none = Fit(VectorXd::Zero(kSamples));
  EXPECT_EQ(none.response, ResponseShape::kNoResponse);
  EXPECT_TRUE(none.ToTransferFunction().IsZero());
}

TEST(SopdtFitTest, SaysWhatIsWrongWithTheResponse) {
  const auto message = [](const VectorXd& response, double dt) {
    return std::string(
        FitSopdt(response, dt, FopdtOptions()).status().message());
  };
  VectorXd response = Lags(1.0, 5.0, 2.0, 1.0);
  EXPECT_THAT(message(response, -1.0), HasSubstr("sample_time is -1"));
  EXPECT_THAT(message(response.head(5), 0.2), HasSubstr("has 5 samples"));
  response(7) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message(response, 0.2), HasSubstr("sample 7"));
}

}  // namespace
}  // namespace mle
