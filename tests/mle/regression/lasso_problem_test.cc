#include "mle/regression/lasso_problem.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Rows `first` … `last` of a series with one response.
struct Window {
  LaggedSeries series;
  RegressionRows rows;

  Window(const Record& record, int order, RowRange range,
         const Eigen::VectorXd& offset = {})
      : series(record, order, offset) {
    std::mt19937_64 random(3);
    rows = {&series, range, RandomMatrix(2, range.rows(), random)};
    rows.responses.array() += 0.7;
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  LassoProblem Problem(Scaling scaling) const {
    return MakeLassoProblem(ComputeLaggedMoments({&rows, 1}), scaling);
  }
};

Record RandomRecord(int samples) {
  std::mt19937_64 random(5);
  Record record;
  record.sample_time = 1.0;
  record.outputs = RandomMatrix(2, samples, random).array() + 2.0;
  record.inputs = 50.0 * RandomMatrix(2, samples, random);
  return record;
}

// Some hundred roundings of numbers of the size of the largest moment, 10 times
// the variance here.
constexpr double kMomentTolerance = 1e-12;

TEST(MakeLassoProblemTest, StandardisesAsTheDenseMatrixWouldBe) {
  const Window window(RandomRecord(200), 3, {3, 199});
  const LassoProblem problem = window.Problem(Scaling::kStandardise);
  const Eigen::MatrixXd X = window.series.Regressors(window.rows.rows);
  const Eigen::MatrixXd& e = window.rows.responses;
  const double rows = 197.0;

  const Eigen::VectorXd mean = X.rowwise().mean();
  const Eigen::MatrixXd centred = X.colwise() - mean;
  const Eigen::VectorXd scale =
      (centred.rowwise().squaredNorm() / rows).cwiseSqrt();
  const Eigen::MatrixXd Z = scale.asDiagonal().inverse() * centred;
  const Eigen::MatrixXd f = e.colwise() - e.rowwise().mean();

  EXPECT_EQ(problem.rows, 197);
  EXPECT_THAT(problem.constant_regressors, IsEmpty());
  EXPECT_TRUE(problem.regressor_mean.isApprox(mean, kMomentTolerance));
  EXPECT_TRUE(problem.scale.isApprox(scale, kMomentTolerance));
  EXPECT_TRUE(
      problem.gram.isApprox(Z * Z.transpose() / rows, kMomentTolerance));
  EXPECT_TRUE(
      problem.correlation.isApprox(Z * f.transpose() / rows, kMomentTolerance));
  EXPECT_TRUE(problem.response_square.isApprox(f.rowwise().squaredNorm() / rows,
                                               kMomentTolerance));
  EXPECT_TRUE(
      problem.response_mean.isApprox(e.rowwise().mean(), kMomentTolerance));
  EXPECT_EQ(problem.gram, problem.gram.transpose());

  const Eigen::VectorXd beta = Eigen::VectorXd::LinSpaced(12, -1.0, 2.0);
  EXPECT_TRUE(problem.Unscale(beta).isApprox(beta.cwiseQuotient(scale),
                                             kMomentTolerance));
}

// Each group about its own means, and divided by the spread about them.
TEST(MakeLassoProblemTest, CentresEachGroupByItself) {
  const Window window(RandomRecord(200), 3, {3, 199});
  RegressionRows parts[] = {window.rows, window.rows};
  parts[0].rows = {3, 89};
  parts[1].rows = {90, 199};
  parts[1].group = 2;  // and none in group 1
  parts[0].responses = window.rows.responses.rightCols(87);
  parts[1].responses = window.rows.responses.leftCols(110).array() + 5.0;
  const LassoProblem problem = MakeLassoProblem(
      ComputeLaggedMoments(parts, /*num_groups=*/3), Scaling::kStandardise);

  Eigen::MatrixXd Z(12, 197);
  Eigen::MatrixXd f(2, 197);
  int first = 0;
  for (const RegressionRows& part : parts) {
    const Eigen::MatrixXd X = window.series.Regressors(part.rows);
    const Eigen::VectorXd mean = X.rowwise().mean();
    Z.middleCols(first, X.cols()) = X.colwise() - mean;
    f.middleCols(first, X.cols()) =
        part.responses.colwise() - part.responses.rowwise().mean();
    EXPECT_TRUE(problem.regressor_mean.col(part.group).isApprox(mean, 1e-12));
    first += static_cast<int>(X.cols());
  }
  const Eigen::VectorXd scale = (Z.rowwise().squaredNorm() / 197.0).cwiseSqrt();
  Z = scale.asDiagonal().inverse() * Z;
  EXPECT_TRUE(problem.scale.isApprox(scale, kMomentTolerance));
  EXPECT_TRUE(
      problem.gram.isApprox(Z * Z.transpose() / 197.0, kMomentTolerance));
  EXPECT_TRUE(problem.correlation.isApprox(Z * f.transpose() / 197.0,
                                           kMomentTolerance));
  EXPECT_TRUE(problem.response_square.isApprox(
      f.rowwise().squaredNorm() / 197.0, kMomentTolerance));
  EXPECT_TRUE(problem.regressor_mean.col(1).isZero(0.0));
  EXPECT_EQ(problem.gram, problem.gram.transpose());
}

TEST(MakeLassoProblemTest, RawLeavesEverythingAsItIs) {
  const Window window(RandomRecord(200), 3, {3, 199});
  const LassoProblem problem = window.Problem(Scaling::kRaw);
  const Eigen::MatrixXd X = window.series.Regressors(window.rows.rows);
  const Eigen::MatrixXd& e = window.rows.responses;
  EXPECT_TRUE(
      problem.gram.isApprox(X * X.transpose() / 197.0, kMomentTolerance));
  EXPECT_TRUE(problem.correlation.isApprox(X * e.transpose() / 197.0,
                                           kMomentTolerance));
  EXPECT_TRUE(problem.response_square.isApprox(
      e.rowwise().squaredNorm() / 197.0, kMomentTolerance));
  EXPECT_EQ(problem.regressor_mean, Eigen::VectorXd::Zero(12));
  EXPECT_EQ(problem.response_mean, Eigen::VectorXd::Zero(2));
  EXPECT_EQ(problem.scale, Eigen::VectorXd::Ones(12));
}

void ExpectConstant(const LassoProblem& problem, const std::vector<int>& which,
                    const std::string& what) {
  EXPECT_EQ(problem.constant_regressors, which) << what;
  EXPECT_TRUE(problem.gram.allFinite()) << what;
  EXPECT_TRUE(problem.correlation.allFinite()) << what;
  // What is left has unit variance, so that no entry is greater than 1 but
  // for rounding.
  EXPECT_LE(problem.gram.cwiseAbs().maxCoeff(), 1.0 + 1e-9) << what;
  const Eigen::VectorXd b =
      problem.Unscale(Eigen::VectorXd::Ones(problem.num_regressors()));
  const LassoObjective objective(problem, 0);
  for (const int j : which) {
    EXPECT_EQ(problem.scale(j), 0.0) << what;
    EXPECT_TRUE(problem.gram.col(j).isZero(0.0)) << what;
    EXPECT_TRUE(problem.gram.row(j).isZero(0.0)) << what;
    EXPECT_TRUE(problem.correlation.row(j).isZero(0.0)) << what;
    EXPECT_EQ(b(j), 0.0) << what;
    EXPECT_EQ(objective.weights(j), kInfinity) << what;
  }
}

// A held input is found whatever its value and the number of rows, with or
// without an offset that is not quite its mean.
TEST(MakeLassoProblemTest, HeldInputsAreConstant) {
  for (const int samples : {20, 2000, 50000}) {
    for (const double value : {0.0, 1e-12 / 3.0, 96.0, 96.1, -1e7 / 3.0}) {
      Record record = RandomRecord(samples);
      record.inputs.row(1).setConstant(value);
      for (const double off :
           {0.0, value, value * (1.0 + 1e-14), 0.7 * value}) {
        const Window window(record, 3, {3, samples - 1},
                            Eigen::Vector4d(2.0, 2.0, 0.0, off));
        ExpectConstant(window.Problem(Scaling::kStandardise), {3, 7, 11},
                       "value " + std::to_string(value) + " less " +
                           std::to_string(off) + ", " +
                           std::to_string(samples) + " samples");
      }
    }
  }
}

// Held for most of the window, then moved: the older lags never see the move.
// The recursion of the Gram matrix has seen it, and must not leave its rounding
// as the variance of a constant column.
TEST(MakeLassoProblemTest, LagsThatDoNotSeeAMoveAreConstant) {
  constexpr int kOrder = 30;
  std::vector<int> unmoved;
  for (int lag = 9; lag <= kOrder; ++lag) unmoved.push_back(4 * lag - 1);
  for (const double held : {0.0, 0.01, 1.0 / 3.0}) {
    Record record = RandomRecord(400);
    record.inputs.row(1).head(391).setConstant(held);
    const Window window(record, kOrder, {kOrder, 399});
    ExpectConstant(window.Problem(Scaling::kStandardise), unmoved,
                   "held at " + std::to_string(held));
  }
}

// Rounding must not correlate a response that does not vary with regressors:
// nothing of it is left to be explained, in one group or in several.
TEST(MakeLassoProblemTest, HeldResponseHasNothingToExplain) {
  for (const int samples : {20, 2000, 50000}) {
    const Window window(RandomRecord(samples), 3, {3, samples - 1});
    const int half = samples / 2;
    for (const double value : {0.0, 1e-12 / 3.0, 96.1, -1e7 / 3.0}) {
      RegressionRows parts[] = {window.rows, window.rows};
      parts[0].rows.last = half - 1;
      parts[1].rows.first = half;
      parts[1].group = 1;
      parts[0].responses = window.rows.responses.leftCols(half - 3);
      parts[1].responses = window.rows.responses.rightCols(samples - half);
      parts[0].responses.row(1).setConstant(value);
      parts[1].responses.row(1).setConstant(2.0 * value);
      const LassoProblem problem = MakeLassoProblem(
          ComputeLaggedMoments(parts, /*num_groups=*/2), Scaling::kStandardise);
      EXPECT_GT(problem.response_square(0), 0.5) << value;
      EXPECT_EQ(problem.response_square(1), 0.0) << value;
      EXPECT_GT(LassoObjective(problem, 0).LambdaMax(), 0.0) << value;
      EXPECT_EQ(LassoObjective(problem, 1).LambdaMax(), 0.0) << value;
    }
  }
}

TEST(LassoObjectiveTest, TakesWeightsAndLeavesConstantsOut) {
  Record record = RandomRecord(50);
  record.inputs.row(0).setConstant(96.0);
  const Window window(record, 1, {1, 49});
  const LassoProblem problem = window.Problem(Scaling::kStandardise);
  EXPECT_EQ(LassoObjective(problem, 1).weights,
            Eigen::Vector4d(1.0, 1.0, kInfinity, 1.0));
  const LassoObjective objective(problem, 1,
                                 Eigen::Vector4d(0.0, 2.0, 3.0, 4.0));
  EXPECT_EQ(objective.weights, Eigen::Vector4d(0.0, 2.0, kInfinity, 4.0));
  EXPECT_TRUE(objective.Validate().ok());
  EXPECT_EQ(objective.correlation, problem.correlation.col(1));
  EXPECT_EQ(objective.response_square, problem.response_square(1));
  EXPECT_DOUBLE_EQ(objective.LambdaMax(),
                   std::max(std::abs(problem.correlation(1, 1)) / 2.0,
                            std::abs(problem.correlation(3, 1)) / 4.0));
}

std::string Message(const LassoObjective& objective) {
  return std::string(objective.Validate().message());
}

TEST(LassoObjectiveTest, ValidateSaysWhatIsWrong) {
  std::mt19937_64 random(1);
  const ExplicitLasso good(RandomMatrix(3, 10, random),
                           RandomVector(10, random));
  ASSERT_TRUE(good.objective.Validate().ok());
  LassoObjective bad = good.objective;
  bad.weights.setOnes(2);
  EXPECT_THAT(Message(bad), HasSubstr("3 × 3"));
  bad = good.objective;
  bad.correlation(1) = kNaN;
  EXPECT_THAT(Message(bad), HasSubstr("not finite"));
  bad = good.objective;
  bad.response_square = kInfinity;
  EXPECT_THAT(Message(bad), HasSubstr("not finite"));
  bad = good.objective;
  bad.weights(2) = -1.0;
  EXPECT_THAT(Message(bad), HasSubstr("weight 2 is -1"));
  bad.weights(2) = kNaN;
  EXPECT_THAT(Message(bad), HasSubstr("weight 2 is nan"));
  bad.weights.setConstant(kInfinity);
  EXPECT_THAT(Message(bad), HasSubstr("nothing to estimate"));
  EXPECT_THAT(Message(LassoObjective()), HasSubstr("0 × 0"));
  bad = good.objective;
  bad.gram = nullptr;
  EXPECT_THAT(Message(bad), HasSubstr("0 × 0"));
}

}  // namespace
}  // namespace mle
