#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/transfer_function.h"
#include "mle/nonlinear/low_order_fit.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// K e^{−Ls} / (T² s² + 2ζT s + 1); its step responses are those of
// transfer_function.h, which solves the differential equation.
TransferFunction SecondOrder(double gain, double time_constant, double damping,
                             double delay) {
  return TransferFunction(
      {gain},
      {time_constant * time_constant, 2.0 * damping * time_constant, 1.0},
      delay);
}

SopdtFit Fit(const Eigen::VectorXd& response, double sample_time,
             double max_delay) {
  const auto fit = FitSopdt(response, sample_time, max_delay);
  EXPECT_TRUE(fit.ok()) << fit.status();
  return *fit;
}

TEST(SopdtFitTest, RecoversWhatIsOfSecondOrder) {
  for (const double damping : {0.05, 0.3, 0.9, 1.0, 1.2, 4.0}) {
    for (const double delay : {0.0, 3.3, 20.0}) {
      for (const double gain : {5.0, -1e-4}) {
        SCOPED_TRACE(testing::Message() << damping << " " << delay);
        const TransferFunction element = SecondOrder(gain, 8.0, damping, delay);
        const SopdtFit fit = Fit(element.StepResponse(0.5, 400), 0.5, 30.0);
        EXPECT_NEAR(fit.gain, gain, 1e-4 * std::abs(gain));
        EXPECT_NEAR(fit.time_constant, 8.0, 1e-3);
        EXPECT_NEAR(fit.damping, damping, 1e-3 * damping);
        EXPECT_NEAR(fit.delay, delay, 5e-3);
        EXPECT_LT(fit.largest_difference, 1e-5);
      }
    }
  }
}

// Of a response of third order the fit is near, but not exact, and the largest
// difference is that of the step responses.
TEST(SopdtFitTest, SaysHowNearItIs) {
  const TransferFunction third({2.0}, {64.0, 48.0, 12.0, 1.0}, 1.0);
  const Eigen::VectorXd response = third.StepResponse(0.25, 300);
  const SopdtFit fit = Fit(response, 0.25, 10.0);
  const Eigen::VectorXd found =
      SecondOrder(fit.gain, fit.time_constant, fit.damping, fit.delay)
          .StepResponse(0.25, 300);
  EXPECT_NEAR(fit.largest_difference,
              (found - response).cwiseAbs().maxCoeff() / response.maxCoeff(),
              1e-8);
  EXPECT_GT(fit.largest_difference, 1e-4);
  EXPECT_LT(fit.largest_difference, 0.02);
}

// No point nearby has smaller squares.
TEST(SopdtFitTest, IsALocalOptimum) {
  const TransferFunction third({2.0, 1.0}, {60.0, 40.0, 9.0, 1.0}, 2.0);
  const Eigen::VectorXd response = third.StepResponse(0.25, 300);
  const SopdtFit fit = Fit(response, 0.25, 10.0);
  const auto squares = [&](double k, double t, double z, double l) {
    return (SecondOrder(fit.gain * k, fit.time_constant * t, fit.damping * z,
                        std::max(fit.delay + l, 0.0))
                .StepResponse(0.25, 300) -
            response)
        .squaredNorm();
  };
  const double best = squares(1.0, 1.0, 1.0, 0.0);
  for (const double step : {-1e-3, 1e-3}) {
    EXPECT_GE(squares(1.0 + step, 1.0, 1.0, 0.0), best);
    EXPECT_GE(squares(1.0, 1.0 + step, 1.0, 0.0), best);
    EXPECT_GE(squares(1.0, 1.0, 1.0 + step, 0.0), best);
    EXPECT_GE(squares(1.0, 1.0, 1.0, step), best);
  }
}

TEST(SopdtFitTest, FaultsSayWhatWouldBeRight) {
  const Eigen::VectorXd response = Eigen::VectorXd::LinSpaced(20, 0.0, 1.0);
  const auto message = [](const absl::StatusOr<SopdtFit>& fit) {
    EXPECT_FALSE(fit.ok());
    return std::string(fit.status().message());
  };
  EXPECT_THAT(message(FitSopdt(response, 0.0, 1.0)),
              HasSubstr("sample_time is 0"));
  EXPECT_THAT(message(FitSopdt(response, 1.0, -1.0)),
              HasSubstr("max_delay is -1"));
  EXPECT_THAT(message(FitSopdt(response.head(9), 1.0, 1.0)),
              HasSubstr("has 9 samples"));
  EXPECT_THAT(message(FitSopdt(Eigen::VectorXd::Zero(20), 1.0, 1.0)),
              HasSubstr("not all 0"));
}

}  // namespace
}  // namespace mle
