#include "mle/nonlinear/serial_correlation.h"

#include <cmath>
#include <memory>
#include <vector>

#include "Eigen/LU"
#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr NoiseShape kWhite = {.ratio = 0.0};
constexpr int kRecords = 200;

// Linear estimates of all parameters under white noise, about the truth.
struct LinearFit {
  VectorXd errors;
  VectorXd variances;  // as white noise would have
  double statistic = 0.0;
  SerialInflation inflation;
};

LinearFit FitAbout(const RecordNoise& noise, unsigned seed, int samples = 1500,
                   const OutputErrorOptions& options = {}) {
  auto setups = SetUpOutputs(
      TwoElements(), MakeRecords(TwoElements(), samples, seed, noise), options);
  EXPECT_TRUE(setups.ok()) << setups.status();
  const OutputErrorProblem& problem = *(*setups)[0].problem;
  const std::vector<SegmentColumns> columns =
      problem.Linearise((*setups)[0].start, kWhite, {true, true});
  const WhitenedColumns whitened = problem.Whiten(columns, kWhite);
  const MatrixXd inverse =
      (whitened.jacobian.transpose() * whitened.jacobian).inverse();
  LinearFit fit;
  fit.errors = inverse * whitened.jacobian.transpose() * whitened.residuals;
  const double squares =
      (whitened.residuals - whitened.jacobian * fit.errors).squaredNorm();
  const double variance =
      squares / (problem.num_innovations(kWhite) - whitened.num_amplitudes - 6);
  fit.variances = variance * inverse.diagonal();
  fit.statistic = (whitened.jacobian * fit.errors).squaredNorm() / variance;
  fit.inflation = InflationOf(problem, (*setups)[0].start, whitened,
                              {true, true}, kWhite, /*longest=*/60);
  return fit;
}

// Inputs stand, whatever they are.
Record AtRest(int samples, unsigned seed, const RecordNoise& noise) {
  ProcessModel dead = TwoElements();
  dead.element(0, 0) = TransferFunction::FirstOrder(0.0, 4.0, 1.0);
  dead.element(0, 1) = TransferFunction::FirstOrder(0.0, 6.0, 2.3);
  Record record = MakeRecord(dead, samples, seed, noise);
  record.inputs.setConstant(3.0);
  return record;
}

// Factors are 1 where the noise is what the shape says, but for one in forty
// numbers that are larger by chance.
TEST(SerialCorrelationTest, WhiteNoiseNeedsNoInflation) {
  Eigen::Index inflated = 0;
  for (unsigned seed = 1; seed <= kRecords; ++seed) {
    const SerialInflation inflation =
        FitAbout({.variance = 0.01}, seed).inflation;
    inflated += (inflation.variances.array() > 1.0).count();
    EXPECT_LT(inflation.variances.maxCoeff(), 2.0) << "seed " << seed;
    EXPECT_LT(inflation.statistic, 1.6) << "seed " << seed;
  }
  EXPECT_LT(inflated, 6 * kRecords / 15);
}

// Under coloured noise that the shape knows nothing of, the spread of the
// estimates is what the inflated variances say, and the mean of the likelihood
// ratio is that of χ² again.
TEST(SerialCorrelationTest, InflatedVariancesAreThoseOfTheEstimates) {
  VectorXd squares = VectorXd::Zero(6);
  VectorXd white = VectorXd::Zero(6);
  VectorXd inflated = VectorXd::Zero(6);
  double statistic = 0.0;
  double calibrated = 0.0;
  for (unsigned seed = 1; seed <= kRecords; ++seed) {
    const LinearFit fit = FitAbout({.shock = 0.01, .pole = 0.7}, seed);
    squares += fit.errors.cwiseAbs2() / kRecords;
    white += fit.variances / kRecords;
    inflated += fit.variances.cwiseProduct(fit.inflation.variances) / kRecords;
    statistic += fit.statistic / kRecords;
    calibrated += fit.statistic / fit.inflation.statistic / kRecords;
  }
  for (int k = 0; k < 6; ++k) {
    EXPECT_GT(squares(k), 1.2 * white(k)) << k;
    EXPECT_NEAR(inflated(k) / squares(k), 1.0, 0.3) << k;
  }
  EXPECT_GT(statistic, 2.0 * 6.0);
  EXPECT_NEAR(calibrated, 6.0, 2.0);
}

// Few samples with moves, and many at rest: the spread is right where without
// them too little is said.
TEST(SerialCorrelationTest, RecordsAtRestTellWhatTheNoiseDoes) {
  const RecordNoise noise = {.shock = 0.01, .pole = 0.7};
  double squares = 0.0;
  double alone = 0.0;
  double with_rest = 0.0;
  for (unsigned seed = 1; seed <= kRecords; ++seed) {
    const LinearFit fit = FitAbout(noise, seed, 250);
    OutputErrorOptions options;
    options.at_rest = std::make_shared<const std::vector<Record>>(
        std::vector<Record>{AtRest(4000, 5000 + seed, noise)});
    const LinearFit with = FitAbout(noise, seed, 250, options);
    EXPECT_EQ(fit.errors, with.errors);
    squares += fit.errors(0) * fit.errors(0);
    alone += fit.variances(0) * fit.inflation.variances(0);
    with_rest += with.variances(0) * with.inflation.variances(0);
  }
  EXPECT_GT(with_rest, 1.1 * alone);
  EXPECT_NEAR(with_rest / squares, 1.0, 0.25);
}

// A dead time that the records do not determine, and nothing free.
TEST(SerialCorrelationTest, WithoutEstimatesThereIsNothingToInflate) {
  auto setups =
      SetUpOutputs(TwoElements(), MakeRecords(TwoElements(), 400, 1, {}), {});
  ASSERT_TRUE(setups.ok()) << setups.status();
  const OutputErrorProblem& problem = *(*setups)[0].problem;
  const WhitenedColumns whitened = problem.Whiten(
      problem.Linearise((*setups)[0].start, kWhite, {true, true}), kWhite);
  const SerialInflation inflation = InflationOf(
      problem, (*setups)[0].start, whitened, {false, false}, kWhite, 60);
  EXPECT_EQ(inflation.statistic, 1.0);
  EXPECT_EQ(inflation.variances, VectorXd::Ones(6));
  const MatrixXd covariance = MatrixXd::Random(6, 6);
  EXPECT_EQ(inflation.Scale(covariance), covariance);
}

}  // namespace
}  // namespace mle
