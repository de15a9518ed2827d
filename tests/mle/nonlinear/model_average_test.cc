#include "mle/nonlinear/model_average.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::VectorXd;

OutputFit Fit(double gain, double error, double degrees) {
  OutputFit fit;
  fit.point.values = {{gain, 10.0, 2.0}};
  fit.point.SetCells(0.5);
  fit.free = {true};
  fit.covariance = Eigen::Vector3d(error * error, 0.04, 0.01).asDiagonal();
  fit.degrees_of_freedom = VectorXd::Constant(3, degrees);
  fit.certificate.search_confirmed = true;
  fit.certificate.gradient = 1e-6;
  return fit;
}

TEST(ModelAverageTest, OneFitIsItself) {
  const OutputFit fit = Fit(2.0, 0.3, 7.0);
  const std::vector<WeightedFit> parts = {{1.0, &fit}};
  EXPECT_EQ(Average(parts, 0.5).covariance, fit.covariance);
  const Interval interval = MixtureInterval(parts, 0, 0.95);
  const double half = StudentTwoSidedQuantile(0.05, 7.0) * 0.3;
  EXPECT_NEAR(interval.low, 2.0 - half, 1e-12);
  EXPECT_NEAR(interval.high, 2.0 + half, 1e-12);
}

TEST(ModelAverageTest, MomentsAreThoseOfTheMixture) {
  const OutputFit a = Fit(2.0, 0.3, 10.0);
  OutputFit b = Fit(3.0, 0.1, 20.0);
  b.certificate.search_confirmed = false;
  b.certificate.gradient = 1e-3;
  const OutputFit average = Average({{0.25, &a}, {0.75, &b}}, 0.5);
  EXPECT_NEAR(average.point.values[0].gain, 2.75, 1e-15);
  // Within the fits and between them.
  EXPECT_NEAR(average.covariance(0, 0),
              0.25 * 0.09 + 0.75 * 0.01 + 0.25 * 0.75 * 1.0, 1e-15);
  EXPECT_NEAR(average.covariance(1, 1), 0.04, 1e-15);
  EXPECT_FALSE(average.certificate.search_confirmed);
  EXPECT_EQ(average.certificate.gradient, 1e-3);
}

TEST(ModelAverageTest, IntervalsAreQuantilesOfTheMixture) {
  const OutputFit a = Fit(2.0, 0.3, 5.0);
  const OutputFit b = Fit(2.4, 0.1, 50.0);
  const std::vector<WeightedFit> parts = {{0.3, &a}, {0.7, &b}};
  const Interval interval = MixtureInterval(parts, 0, 0.9);
  const auto tail = [](double x) {
    return 0.3 * StudentTail((x - 2.0) / 0.3, 5.0) +
           0.7 * StudentTail((x - 2.4) / 0.1, 50.0);
  };
  EXPECT_NEAR(tail(interval.high), 0.05, 1e-9);
  EXPECT_NEAR(tail(interval.low), 0.95, 1e-9);
  // Where the parts agree, so does the mixture.
  const Interval same = MixtureInterval({{0.3, &a}, {0.7, &a}}, 0, 0.9);
  const Interval one = MixtureInterval({{1.0, &a}}, 0, 0.9);
  EXPECT_NEAR(same.low, one.low, 1e-9);
  EXPECT_NEAR(same.high, one.high, 1e-9);
}

TEST(ModelAverageTest, WhatIsNotDeterminedHasNoBounds) {
  OutputFit a = Fit(2.0, 0.3, 5.0);
  a.covariance(2, 2) = std::numeric_limits<double>::infinity();
  const OutputFit b = Fit(2.0, 0.3, 5.0);
  const Interval interval = MixtureInterval({{0.5, &a}, {0.5, &b}}, 2, 0.95);
  EXPECT_EQ(interval.low, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(interval.high, std::numeric_limits<double>::infinity());
  // And what is not fitted is a point.
  OutputFit held = Fit(2.0, 0.0, 5.0);
  const Interval point = MixtureInterval({{0.5, &held}, {0.5, &held}}, 0, 0.95);
  EXPECT_EQ(point.low, 2.0);
  EXPECT_EQ(point.high, 2.0);
}

// Akaike: two parameters that are not there cost 4 units of AIC less what
// chance explains.
TEST(ModelAverageTest, ADetectableChangeReachesTheStatistic) {
  const OutputFit narrow = Fit(2.0, 0.1, 10.0);
  const OutputFit wide = Fit(2.0, 0.5, 10.0);
  EXPECT_NEAR(DetectableChange({{1.0, &narrow}}, 0, 9.0), 0.3, 1e-12);
  for (const double weight : {0.5, 1e-3, 1e-9}) {
    const double change =
        DetectableChange({{1.0 - weight, &narrow}, {weight, &wide}}, 0, 30.0);
    const double ratio =
        -2.0 *
        std::log((1.0 - weight) * std::exp(-0.5 * std::pow(change / 0.1, 2)) +
                 weight * std::exp(-0.5 * std::pow(change / 0.5, 2)));
    EXPECT_NEAR(ratio, 30.0, 1e-9) << weight;
  }
  // The change of a gain alone is seen better than the gain is known where
  // something else that would make up for it has not changed.
  OutputFit together = narrow;
  together.covariance(1, 1) = 4.0;
  together.covariance(0, 1) = together.covariance(1, 0) = 0.8 * 0.1 * 2.0;
  EXPECT_NEAR(DetectableChange({{1.0, &together}}, 0, 9.0), 0.3 * 0.6, 1e-12);
  OutputFit unknown = Fit(2.0, 0.1, 10.0);
  unknown.covariance(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(DetectableChange({{0.5, &narrow}, {0.5, &unknown}}, 0, 30.0),
            std::numeric_limits<double>::infinity());
}

TEST(ModelAverageTest, OffsetWeightIsAkaikes) {
  EXPECT_NEAR(
      OffsetWeight({{.offsets = 0.0, .drift = 0.0, .num_parameters = 2}}),
      1.0 / (1.0 + std::exp(2.0)), 1e-15);
  EXPECT_NEAR(
      OffsetWeight({{.offsets = 4.0, .drift = 2.0, .num_parameters = 3},
                    {.offsets = 6.0, .drift = 0.0, .num_parameters = 3}}),
      0.5, 1e-15);
  EXPECT_GT(OffsetWeight({{.offsets = 1e3, .drift = 0.0, .num_parameters = 3}}),
            1.0 - 1e-12);
}

}  // namespace
}  // namespace mle
