#include "mle/monitor/output_scores.h"

#include <vector>

#include "Eigen/Cholesky"
#include "gtest/gtest.h"
#include "mle/base/random.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<WhitenedRun> DrawRuns() {
  GaussianNoise noise(1, kRunStream);
  std::vector<WhitenedRun> runs;
  for (const int samples : {40, 3, 25}) {
    runs.push_back(
        {noise.DrawMatrix(samples, 1, 1.0), noise.DrawMatrix(samples, 3, 1.0)});
  }
  return runs;
}

TEST(RobustDeviationTest, IsThatOfANormalVariable) {
  GaussianNoise noise(2, kRunStream);
  std::vector<WhitenedRun> runs = {
      {noise.DrawMatrix(20000, 1, 3.0), MatrixXd(20000, 0)}};
  runs[0].innovations.head(1000).setConstant(1e6);
  // A twentieth of outliers moves the median by a few percent.
  EXPECT_NEAR(RobustDeviation(runs), 3.0, 0.3);
  EXPECT_EQ(RobustDeviation({}), 0.0);
}

TEST(AutocovariancesTest, AreSumsOfProductsWithinRuns) {
  const std::vector<WhitenedRun> runs = {
      {VectorXd{{1.0, 2.0, -1.0}}, MatrixXd(3, 0)},
      {VectorXd{{4.0}}, MatrixXd(1, 0)}};
  const std::vector<double> covariances = AutocovariancesOf(runs, 3);
  EXPECT_DOUBLE_EQ(covariances[0], 22.0 / 4.0);
  EXPECT_DOUBLE_EQ(covariances[1], 0.0 / 4.0);
  EXPECT_DOUBLE_EQ(covariances[2], -1.0 / 4.0);
  EXPECT_DOUBLE_EQ(covariances[3], 0.0);
}

TEST(ScoreVarianceTest, IsThatOfTheDenseFormula) {
  const std::vector<WhitenedRun> runs = DrawRuns();
  const std::vector<double> covariances = {1.2, 0.4, -0.1, 0.2};
  MatrixXd expected = MatrixXd::Zero(3, 3);
  for (const WhitenedRun& run : runs) {
    const auto n = run.innovations.size();
    MatrixXd dense = MatrixXd::Zero(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      for (Eigen::Index l = 0; l < n; ++l) {
        const auto h = static_cast<int>(std::abs(k - l));
        if (h < 4) dense(k, l) = (1.0 - h / 4.0) * covariances[h];
      }
    }
    expected += run.sensitivities.transpose() * dense * run.sensitivities;
  }
  EXPECT_LT((ScoreVariance(runs, covariances, 3) - expected).norm(), 1e-10);
}

TEST(AllowForVarianceTest, LessVarianceThanExpectedChangesNothing) {
  const ScoreSums sums = SumScores(DrawRuns(), 3);
  ScoreSums allowed = sums;
  AllowForVariance(0.5 * sums.information, allowed);
  EXPECT_LT((allowed.score - sums.score).norm(), 1e-9);
  EXPECT_LT((allowed.information - sums.information).norm(), 1e-9);
}

TEST(AllowForVarianceTest, MoreMakesTheNormalScore) {
  const ScoreSums sums = SumScores(DrawRuns(), 3);
  GaussianNoise noise(3, kRunStream);
  const MatrixXd root = noise.DrawMatrix(3, 3, 2.0);
  const MatrixXd variance = sums.information + root * root.transpose();
  ScoreSums allowed = sums;
  AllowForVariance(variance, allowed);
  const Eigen::LDLT<MatrixXd> solver(variance);
  EXPECT_LT(
      (allowed.score - sums.information * solver.solve(sums.score)).norm(),
      1e-9);
  EXPECT_LT(
      (allowed.information - sums.information * solver.solve(sums.information))
          .norm(),
      1e-9);
}

TEST(UnexplainedSquaresTest, AreTheResidualOfLeastSquares) {
  std::vector<WhitenedRun> runs = DrawRuns();
  const double own = UnexplainedSquares(SumScores(runs, 3));
  const VectorXd change{{0.5, -2.0, 1.0}};
  for (WhitenedRun& run : runs) run.innovations += run.sensitivities * change;
  EXPECT_NEAR(UnexplainedSquares(SumScores(runs, 3)), own, 1e-9);
}

}  // namespace
}  // namespace mle
