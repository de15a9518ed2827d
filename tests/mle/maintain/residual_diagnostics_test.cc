#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/maintain/validation.h"

namespace mle {
namespace {

constexpr int kErrorSamples = 1500;

// One output that the predictor below leaves as it is, and one input.
Record RecordOf(const Eigen::RowVectorXd& error,
                const Eigen::RowVectorXd& input) {
  Record record;
  record.sample_time = 1.0;
  record.outputs = error;
  record.inputs = input;
  return record;
}

Eigen::MatrixXd Identity(const Record& record, int) { return record.outputs; }

Eigen::RowVectorXd White(std::uint64_t seed, int stream) {
  return GaussianNoise(seed, stream).DrawMatrix(1, kErrorSamples, 1.0);
}

ResidualReport Examine(const Eigen::RowVectorXd& error,
                       const Eigen::RowVectorXd& input, int lags = 25) {
  return ExamineResiduals(Identity, {RecordOf(error, input)}, lags)[0];
}

TEST(DiagnosticsTest, WhiteErrorsPassAtTheLevelOfTheTests) {
  int coloured = 0;
  int correlated = 0;
  double outside = 0.0;
  const int runs = 300;
  for (int s = 1; s <= runs; ++s) {
    const ResidualReport report = Examine(White(s, 0), White(s, 1));
    coloured += report.white() ? 0 : 1;
    correlated += report.inputs[0].correlated() ? 1 : 0;
    outside += report.outside;
  }
  // 1 % of 300 is 3: binomial, 12 or more have a probability below 1e-4.
  EXPECT_LE(coloured, 11);
  EXPECT_LE(correlated, 11);
  EXPECT_NEAR(outside / runs, 0.01, 0.006);
}

TEST(DiagnosticsTest, AnAutoregressionIsNotWhiteAndHasItsAutocorrelation) {
  Eigen::RowVectorXd error = White(3, 0);
  for (int k = 1; k < kErrorSamples; ++k) error(k) += 0.6 * error(k - 1);
  const ResidualReport report = Examine(error, White(3, 1));
  EXPECT_FALSE(report.white());
  // Standard error of r(1) about 0.02.
  EXPECT_NEAR(report.autocorrelation(0), 0.6, 0.08);
  EXPECT_NEAR(report.autocorrelation(1), 0.36, 0.1);
}

TEST(DiagnosticsTest, AMissingResponseIsFoundAtItsLag) {
  const Eigen::RowVectorXd input = White(5, 1);
  Eigen::RowVectorXd error = White(5, 0);
  for (int k = 4; k < kErrorSamples; ++k) error(k) += 0.3 * input(k - 4);
  const ResidualReport report = Examine(error, input);
  EXPECT_TRUE(report.inputs[0].correlated());
  EXPECT_EQ(report.inputs[0].largest_lag, 4);
  EXPECT_NEAR(report.inputs[0].values(25 + 4), 0.3 / std::sqrt(1.09), 0.08);
}

TEST(DiagnosticsTest, FeedbackIsNotTakenForMisfit) {
  const Eigen::RowVectorXd error = White(7, 0);
  Eigen::RowVectorXd input = 0.3 * White(7, 1);
  // The input answers to the sample just measured, and to the one before.
  for (int k = 1; k < kErrorSamples; ++k) {
    input(k) -= error(k) + 0.5 * error(k - 1);
  }
  const ResidualReport report = Examine(error, input);
  EXPECT_FALSE(report.inputs[0].correlated());
  EXPECT_LT(report.inputs[0].values(25), -report.inputs[0].limit);      // lag 0
  EXPECT_LT(report.inputs[0].values(25 - 1), -report.inputs[0].limit);  // −1
}

TEST(DiagnosticsTest, MissingSamplesAndStillInputsAreNoEvidence) {
  Eigen::RowVectorXd error = White(9, 0);
  for (int k = 0; k < kErrorSamples; k += 7) error(k) = std::nan("");
  const ResidualReport report =
      Examine(error, Eigen::RowVectorXd::Zero(kErrorSamples));
  EXPECT_TRUE(report.white());
  EXPECT_TRUE(std::isfinite(report.p_value));
  EXPECT_EQ(report.inputs[0].p_value, 1.0);
  EXPECT_TRUE(report.inputs[0].values.allFinite());
  EXPECT_EQ(report.samples, kErrorSamples - (kErrorSamples + 6) / 7);
}

TEST(DiagnosticsTest, UnitsChangeNothing) {
  Eigen::RowVectorXd error = White(11, 0);
  const Eigen::RowVectorXd input = White(11, 1);
  const ResidualReport a = Examine(error, input);
  const ResidualReport b = Examine(1e4 * error, 1e-3 * input);
  EXPECT_NEAR(a.ljung_box, b.ljung_box, 1e-8 * a.ljung_box);
  EXPECT_NEAR(a.inputs[0].statistic, b.inputs[0].statistic, 1e-7);
}

}  // namespace
}  // namespace mle
