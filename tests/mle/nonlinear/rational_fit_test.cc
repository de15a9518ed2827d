#include "mle/nonlinear/rational_fit.h"

#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

RationalFit Fit(const TransferFunction& element, double max_delay) {
  RationalOptions options;
  options.max_delay = max_delay;
  const auto fit = FitRational(element.StepResponse(0.2, 400), 0.2, options);
  EXPECT_TRUE(fit.ok()) << fit.status();
  return *fit;
}

// As many poles as the element has, and its dead time.
TEST(RationalFitTest, FindsLagsOfItsOwnForm) {
  const auto first = TransferFunction::FirstOrder(-3.0, 8.0, 2.3);
  const RationalFit one = Fit(first, 5.0);
  EXPECT_LT(one.relative_error, 1e-3);
  EXPECT_EQ(one.element.denominator().size(), 2u);
  EXPECT_NEAR(one.element.StaticGain(), -3.0, 0.01);
  EXPECT_NEAR(one.element.delay(), 2.3, 0.05);
  // 2 / ((5 s + 1)(1.5 s + 1))
  const RationalFit two =
      Fit(TransferFunction({2.0}, {7.5, 6.5, 1.0}, 1.0), 3.0);
  EXPECT_LT(two.relative_error, 1e-3);
  EXPECT_LE(two.element.denominator().size(), 4u);
}

TEST(RationalFitTest, DescribesLeadsAndInverseResponses) {
  // 12.8 (8 s + 1) / ((16.7 s + 1)(4 s + 1)), and −4 s in place of 8 s
  for (const double lead : {8.0, -4.0}) {
    const TransferFunction element({12.8 * lead, 12.8}, {66.8, 20.7, 1.0}, 1.0);
    const RationalFit fit = Fit(element, 2.0);
    EXPECT_LT(fit.relative_error, 1e-3) << lead;
    EXPECT_TRUE(fit.element.Validate().ok());
  }
}

// A response that no five real poles describe is described as well as they can.
TEST(RationalFitTest, SaysWhatIsLeft) {
  const TransferFunction oscillation({1.0}, {4.0, 0.4, 1.0}, 0.0);
  const RationalFit fit = Fit(oscillation, 0.0);
  EXPECT_GT(fit.relative_error, 0.01);
  EXPECT_LT(fit.relative_error, 0.5);
  const Eigen::VectorXd target = oscillation.StepResponse(0.2, 400);
  EXPECT_NEAR(
      fit.relative_error,
      (target - fit.element.StepResponse(0.2, 400)).norm() / target.norm(),
      1e-12);
}

TEST(RationalFitTest, NothingStaysNothing) {
  const auto fit = FitRational(Eigen::VectorXd::Zero(20), 1.0, {});
  ASSERT_TRUE(fit.ok());
  EXPECT_TRUE(fit->element.IsZero());
}

TEST(RationalFitTest, NamesWhatIsInvalid) {
  const auto message = [](const Eigen::VectorXd& response, double sample_time,
                          const RationalOptions& options) {
    return std::string(
        FitRational(response, sample_time, options).status().message());
  };
  Eigen::VectorXd step = Eigen::VectorXd::Ones(10);
  RationalOptions options;
  options.min_delay = 2.0;
  EXPECT_THAT(message(step, 1.0, options), HasSubstr("from 2 to 0"));
  options = {};
  options.max_order = 0;
  EXPECT_THAT(message(step, 1.0, options), HasSubstr("max_order is 0"));
  options = {};
  options.tolerance = 0.0;
  EXPECT_THAT(message(step, 1.0, options), HasSubstr("tolerance is 0"));
  EXPECT_THAT(message(step, 0.0, {}), HasSubstr("sample_time is 0"));
  EXPECT_THAT(message(Eigen::VectorXd::Ones(3), 1.0, {}),
              HasSubstr("3 samples"));
  step(4) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(step, 1.0, {}), HasSubstr("all finite"));
}

}  // namespace
}  // namespace mle
