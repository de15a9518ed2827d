#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/fitted_output.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using Eigen::VectorXd;

FittedOutput FitRightModel(const RecordNoise& noise, unsigned seed) {
  return FitRecords(TwoElements(), noise, seed);
}

VectorXd Mean(const std::vector<LinearEstimate>& estimates) {
  VectorXd mean = VectorXd::Zero(estimates[0].change.size());
  for (const LinearEstimate& e : estimates) mean += e.weight * e.change;
  return mean;
}

TEST(RatioIntegrationTest, WeightsAreAProbability) {
  for (const double increment : {0.0, 1e-6, 1e-4}) {
    const FittedOutput f =
        FitRightModel({.variance = 0.01, .increment = increment}, 3);
    const auto estimates = IntegrateRatio(f.problem(), f.fit, true);
    double total = 0.0;
    for (const LinearEstimate& e : estimates) {
      EXPECT_GT(e.weight, 0.0);
      EXPECT_TRUE(e.change.allFinite());
      total += e.weight;
    }
    EXPECT_NEAR(total, 1.0, 1e-12);
    // Between the ratios estimates differ by less than their errors.
    const VectorXd mean = Mean(estimates);
    for (Eigen::Index k = 0; k < mean.size(); ++k) {
      EXPECT_LT(std::abs(mean(k)), std::sqrt(f.fit.covariance(k, k)));
    }
  }
}

// Outputs that are zero, at gains that are next to nothing or nothing: numbers
// at the ends of their range make no step that is none.
TEST(RatioIntegrationTest, ExactRecordsMakeFiniteSteps) {
  const ProcessModel model = TwoElements();
  std::vector<Record> records = MakeRecords(model, 400, 3, {});
  for (Record& record : records) record.outputs.setZero();
  const auto setups = SetUpOutputs(model, records, {});
  ASSERT_TRUE(setups.ok()) << setups.status();
  const OutputSetup& setup = setups->front();
  OutputFit fit =
      FitOutput(*setup.problem, setup.start, {true, true}, setup.bounds, {});
  for (const double gain :
       {1e-9, 1e-60, 1e-100, 1e-140, 1e-150, 1e-170, 1e-300, 0.0}) {
    for (ElementValues& values : fit.point.values) values.gain = gain;
    for (const LinearEstimate& e : IntegrateRatio(*setup.problem, fit, true)) {
      EXPECT_TRUE(e.change.allFinite()) << gain << ": " << e.change.transpose();
      EXPECT_GT(e.weight, 0.0) << gain;
    }
  }
}

// A step of Gauss and Newton to another ratio is where the fit under it ends.
TEST(RatioIntegrationTest, ChangesAreThoseOfRefits) {
  const FittedOutput f =
      FitRightModel({.variance = 0.01, .increment = 1e-4}, 4);
  const OutputErrorProblem& problem = f.problem();
  OutputErrorOptions white;
  white.estimate_drift = false;  // ρ = 0
  const OutputFit refit =
      FitOutput(problem, f.fit.point, {true, true}, f.setups[0].bounds, white);
  // In records without drift ρ = 0 stands first among the estimates.
  const FittedOutput still = FitRightModel({.variance = 0.01}, 5);
  const auto estimates = IntegrateRatio(still.problem(), still.fit, true);
  const OutputFit still_refit =
      FitOutput(still.problem(), still.fit.point, {true, true},
                still.setups[0].bounds, white);
  EXPECT_GT(std::abs(refit.point.values[0].gain - f.fit.point.values[0].gain),
            0.0);
  for (int j = 0; j < 2; ++j) {
    const double deviation = std::sqrt(still.fit.covariance(3 * j, 3 * j));
    EXPECT_NEAR(still.fit.point.values[j].gain + estimates[0].change(3 * j),
                still_refit.point.values[j].gain, 0.05 * deviation);
  }
}

// Where drift is plain the weights gather about its ratio, and what is not
// known of it widens nothing.
TEST(RatioIntegrationTest, PlainDriftIsFound) {
  const FittedOutput f =
      FitRightModel({.variance = 0.01, .increment = 1e-3}, 6);
  const auto estimates = IntegrateRatio(f.problem(), f.fit, true);
  EXPECT_LE(estimates.size(), 6U);
  double variance = 0.0;
  for (const LinearEstimate& e : estimates) {
    variance += e.weight * e.covariance(0, 0);
  }
  EXPECT_NEAR(variance / f.fit.covariance(0, 0), 1.0, 0.3);
}

// Without drift it cannot be excluded: the gain is less certain than at ρ = 0.
TEST(RatioIntegrationTest, DriftThatCannotBeExcludedCounts) {
  const FittedOutput f = FitRightModel({.variance = 0.01}, 7);
  const auto estimates = IntegrateRatio(f.problem(), f.fit, true);
  EXPECT_GT(estimates.size(), 5U);
  double variance = 0.0;
  for (const LinearEstimate& e : estimates) {
    variance += e.weight * e.covariance(0, 0);
    EXPECT_GE(e.covariance(0, 0), 0.9 * estimates[0].covariance(0, 0));
  }
  EXPECT_GT(variance, 1.05 * estimates[0].covariance(0, 0));
}

// Weights are likelihood times the length of √ρ that each ratio stands for.
TEST(RatioIntegrationTest, EverySquareRootIsAsLikelyBeforehand) {
  const FittedOutput f = FitRightModel({.variance = 0.01}, 9);
  const OutputErrorProblem& problem = f.problem();
  const auto columns =
      LineariseWidely(problem, f.fit.point, f.fit.free, f.fit.noise);
  const double length =
      static_cast<double>(problem.num_samples()) / problem.num_segments();
  std::vector<double> ratios = {0.0};
  std::vector<double> edges = {0.0};  // of √ρ
  for (double log_ratio = -2.0 * std::log(length); log_ratio <= std::log(1e6);
       log_ratio += 1.0) {
    ratios.push_back(std::exp(log_ratio));
    edges.push_back(std::exp(0.5 * (log_ratio - 0.5)));
  }
  edges.push_back(std::sqrt(ratios.back()) * std::exp(0.25));
  const ShapeLikelihood likelihood(problem, columns, f.fit.free,
                                   /*restricted=*/true);
  VectorXd log_weights(ratios.size());
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    const NoiseShape shape = {.ratio = ratios[i]};
    log_weights(static_cast<Eigen::Index>(i)) =
        std::log(edges[i + 1] - edges[i]) - 0.5 * likelihood.At(shape).value;
  }
  std::vector<double> expected;
  double total = 0.0;
  for (const double log_weight : log_weights) {
    const double weight = std::exp(log_weight - log_weights.maxCoeff());
    if (weight <= 1e-3) continue;  // left out
    expected.push_back(weight);
    total += weight;
  }
  const auto estimates = IntegrateRatio(problem, f.fit, true);
  ASSERT_EQ(estimates.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(estimates[i].weight, expected[i] / total, 1e-9);
  }
}

TEST(RatioIntegrationTest, WithoutDriftThereIsOneEstimate) {
  const FittedOutput f = FitRightModel({.variance = 0.01}, 8);
  const auto estimates = IntegrateRatio(f.problem(), f.fit, false);
  ASSERT_EQ(estimates.size(), 1U);
  EXPECT_EQ(estimates[0].covariance, f.fit.covariance);
  EXPECT_EQ(estimates[0].change.norm(), 0.0);
}

}  // namespace
}  // namespace mle
