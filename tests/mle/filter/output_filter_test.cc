#include "mle/filter/output_filter.h"

#include <cmath>
#include <limits>

#include "Eigen/Eigenvalues"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/filter/residual_prediction.h"
#include "tests/mle/filter/noise_records.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

OutputFilter FilterOf(const VectorXd& residual, const FilterOptions& options,
                      double settling_time = 30.0) {
  return FindFilters({residual.transpose()}, 1.0, {false}, settling_time,
                     options, 1)[0];
}

NoiseEstimate LoadBehindALag() {
  return {.variance = 0.2,
          .ratio = 1e-6,
          .ar_ratio = 2e-3,
          .ar_pole = 0.95,
          .ar_damping = 1.3};
}

// On a record that was not seen, errors are within 5 % of the true filter's.
TEST(OutputFilterTest, IsNearlyAsGoodAsTheTrueFilter) {
  const NoiseEstimate walk{.variance = 1.0, .ratio = 0.02};
  const NoiseEstimate first{
      .variance = 1.0, .ratio = 1e-6, .ar_ratio = 0.3, .ar_pole = 0.9};
  for (const NoiseEstimate& noise : {walk, first, LoadBehindALag()}) {
    const OutputFilter filter = FilterOf(DrawNoise(noise, 2000, 1), {});
    ASSERT_TRUE(filter.estimated()) << filter.reason;
    EXPECT_TRUE(filter.kalman.better);
    EXPECT_LT(filter.kalman.error, filter.error_in_use);
    const VectorXd unseen = DrawNoise(noise, 100'000, 2);
    const PredictionGrid grid{.samples = 1, .horizon = 30};
    const DisturbanceSystem system = SystemOf(noise, 1);
    const double truth =
        Together(KalmanErrors(unseen, system, SolveStationaryFilter(system),
                              grid, 1000, unseen.size()))
            .mean();
    const double found =
        Together(KalmanErrors(unseen, filter.Every(1), filter.stationary, grid,
                              1000, unseen.size()))
            .mean();
    EXPECT_LT(found, 1.05 * truth);
  }
}

TEST(OutputFilterTest, TimeConstantOfTheBiasFilter) {
  const OutputFilter filter =
      FilterOf(DrawNoise({.variance = 1.0, .ratio = 0.1}, 4000, 3),
               {.control_period = 4.0});
  EXPECT_EQ(filter.samples_of_period, 4);
  EXPECT_EQ(filter.horizon, 8);  // 30 of the settling time
  EXPECT_NEAR(filter.bias_gain,
              1.0 - std::exp(-4.0 / filter.bias_time_constant), 1e-12);
  // ρ = 0.4 at the control period: g = 0.463.
  EXPECT_NEAR(filter.bias_gain, 0.463, 0.05);
}

// The same filter in use cannot be better than itself in more than noise.
TEST(OutputFilterTest, ErrorsAreThoseOfThePredictions) {
  const VectorXd residual = DrawNoise({.variance = 1.0, .ratio = 0.1}, 3000, 4);
  const VectorXd in_use = VectorXd::Constant(1, 0.27);
  const OutputFilter filter = FilterOf(residual, {.gains_in_use = in_use});
  EXPECT_EQ(filter.gain_in_use, 0.27);
  EXPECT_NEAR(filter.bias.error, filter.error_in_use,
              0.01 * filter.error_in_use);
}

TEST(OutputFilterTest, ScalesWithTheOutput) {
  const VectorXd residual = DrawNoise(LoadBehindALag(), 1500, 5);
  const OutputFilter one = FilterOf(residual, {});
  const OutputFilter many = FilterOf(1e6 * residual, {});
  EXPECT_NEAR(many.bias_gain, one.bias_gain, 1e-6);
  EXPECT_NEAR(many.kalman.error, 1e6 * one.kalman.error,
              1e-3 * many.kalman.error);
}

// Two of three samples are missing: on what was not seen the filter is nearly
// as good as that of all samples.
TEST(OutputFilterTest, MissingSamplesAreBridged) {
  const NoiseEstimate noise{.variance = 1.0, .ratio = 0.05};
  VectorXd residual = DrawNoise(noise, 6000, 6);
  const OutputFilter whole = FilterOf(residual, {});
  for (Eigen::Index k = 0; k < residual.size(); ++k) {
    if (k % 3 != 0) residual(k) = kNan;
  }
  const OutputFilter third = FilterOf(residual, {});
  ASSERT_TRUE(third.estimated());
  const VectorXd unseen = DrawNoise(noise, 50'000, 7);
  const auto error = [&](const OutputFilter& filter) {
    return Together(KalmanErrors(unseen, filter.Every(1), filter.stationary,
                                 {.samples = 1, .horizon = 30}, 1000,
                                 unseen.size()))
        .mean();
  };
  EXPECT_LT(error(third), 1.05 * error(whole));
}

TEST(OutputFilterTest, ReasonsForNoFilter) {
  EXPECT_THAT(FilterOf(VectorXd::Constant(500, kNan), {}).reason,
              HasSubstr("not measured"));
  EXPECT_THAT(FilterOf(VectorXd::Zero(500), {}).reason,
              HasSubstr("nothing disturbs"));
  EXPECT_THAT(FilterOf(DrawNoise({.variance = 1.0}, 80, 1), {}).reason,
              HasSubstr("fewer than 50"));
  const VectorXd residual = DrawNoise({.variance = 1.0}, 500, 1);
  EXPECT_THAT(
      FindFilters({residual.transpose()}, 1.0, {true}, 9.0, {}, 1)[0].reason,
      HasSubstr("integrates"));
  EXPECT_THAT(FilterOf(residual, {.control_period = 1e5}).reason,
              HasSubstr("shorter than a control period"));
}

TEST(OutputFilterTest, OptionsAreChecked) {
  EXPECT_THAT(FilterOptions{.control_period = -1.0}.Validate().message(),
              HasSubstr("filter.control_period = -1"));
  EXPECT_THAT(FilterOptions{.horizon = kNan}.Validate().message(),
              HasSubstr("filter.horizon = nan"));
  FilterOptions options;
  options.gains_in_use = VectorXd::Constant(2, 1.5);
  EXPECT_THAT(options.Validate().message(), HasSubstr("1.5"));
}

// The form of all outputs predicts each as its own filter does.
TEST(OutputFilterTest, OutputsTogether) {
  MatrixXd residuals(2, 1500);
  residuals.row(0) = DrawNoise(LoadBehindALag(), 1500, 8).transpose();
  residuals.row(1) =
      DrawNoise({.variance = 1.0, .ratio = 0.01}, 1500, 9).transpose();
  const std::vector<OutputFilter> filters =
      FindFilters({residuals}, 1.0, {false, false}, 30.0, {}, 2);
  ASSERT_TRUE(filters[0].kalman.better);
  ASSERT_TRUE(filters[1].kalman.better);
  const DisturbanceForm form = CombineFilters(filters, 1);
  const MatrixXd closed = form.A - form.K * form.C;
  EXPECT_LT(closed.eigenvalues().cwiseAbs().maxCoeff(), 1.0);
  EXPECT_EQ(form.R(0), filters[0].noise.variance);
  EXPECT_EQ(form.A.rows(),
            filters[0].Every(1).order() + filters[1].Every(1).order());
}

}  // namespace
}  // namespace mle
