#include "mle/regression/coordinate_descent.h"

#include <cmath>
#include <random>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using Stop = CoordinateDescentOptions::Stop;

// Lags of one slow signal: strongly collinear columns.
ExplicitLasso Collinear(int n, int rows, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd signal(rows + n);
  double value = 0.0;
  for (double& sample : signal) sample = value = 0.98 * value + normal(random);
  Eigen::MatrixXd X(n, rows);
  for (int j = 0; j < n; ++j) X.row(j) = signal.segment(n - j, rows);
  const Eigen::VectorXd e = X.row(0).transpose() - 0.8 * X.row(2).transpose() +
                            0.1 * RandomVector(rows, random);
  return ExplicitLasso(X, e);
}

CoordinateDescentSummary Solve(const ExplicitLasso& problem, double lambda,
                               const CoordinateDescentOptions& options = {},
                               const Eigen::VectorXd& start = {}) {
  const auto summary =
      SolveCoordinateDescent(problem.objective, lambda, start, options);
  EXPECT_TRUE(summary.ok()) << summary.status();
  return *summary;
}

TEST(CoordinateDescentTest, ConvergesToTheGapAskedFor) {
  std::mt19937_64 random(1);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(20);
  weights(0) = 0.0;
  weights(1) = kInfinity;
  weights(2) = 3.0;
  for (const ExplicitLasso& problem :
       {ExplicitLasso(RandomMatrix(20, 60, random), RandomVector(60, random)),
        ExplicitLasso(RandomMatrix(20, 60, random), RandomVector(60, random),
                      weights),
        ExplicitLasso(RandomMatrix(20, 8, random), RandomVector(8, random)),
        Collinear(15, 300, 7)}) {
    for (const double part : {0.9, 0.1, 0.01}) {
      for (const double tolerance : {1e-4, 1e-9}) {
        const double lambda = part * problem.objective.LambdaMax();
        const CoordinateDescentSummary summary =
            Solve(problem, lambda, {.tolerance = tolerance});
        EXPECT_TRUE(summary.converged);
        EXPECT_LE(summary.gap.Relative(), tolerance);
        EXPECT_EQ(
            summary.gap.gap,
            ComputeDualityGap(problem.objective, lambda, summary.beta).gap);
      }
    }
  }
}

TEST(CoordinateDescentTest, IsZeroFromLambdaMaxOn) {
  const ExplicitLasso problem = Collinear(10, 100, 1);
  const CoordinateDescentSummary summary =
      Solve(problem, problem.objective.LambdaMax());
  EXPECT_TRUE(summary.converged);
  EXPECT_EQ(summary.beta, Eigen::VectorXd::Zero(10));
  EXPECT_EQ(summary.sweeps, 1);
}

// Why the relative change is no measure of the error.
TEST(CoordinateDescentTest, RelativeChangeStopsFarFromTheMinimum) {
  const ExplicitLasso problem = Collinear(30, 400, 2);
  const double lambda = 1e-4 * problem.objective.LambdaMax();
  const CoordinateDescentSummary exact = Solve(problem, lambda);
  const CoordinateDescentSummary early = Solve(
      problem, lambda, {.stop = Stop::kRelativeChange, .tolerance = 1e-4});
  EXPECT_TRUE(early.converged);
  EXPECT_LT(early.sweeps, exact.sweeps / 4);
  EXPECT_GT(early.gap.Relative(), 1e3 * exact.gap.Relative());
  EXPECT_GT((early.beta - exact.beta).norm(), 1e-3 * exact.beta.norm());
}

TEST(CoordinateDescentTest, StartsWhereItIsTold) {
  const ExplicitLasso problem = Collinear(15, 300, 3);
  const double lambda = 1e-2 * problem.objective.LambdaMax();
  const CoordinateDescentSummary cold = Solve(problem, lambda);
  const CoordinateDescentSummary warm = Solve(problem, lambda, {}, cold.beta);
  EXPECT_TRUE(warm.converged);
  EXPECT_LT(warm.sweeps, cold.sweeps);
  // Another start, the same (unique) solution: both within a gap of 1e-9 of
  // the primal value, which on the least eigenvalue of G, about 1e-1, lets the
  // coefficients differ by √(2·1e-9/1e-1).
  const CoordinateDescentSummary other =
      Solve(problem, lambda, {}, Eigen::VectorXd::Constant(15, 5.0));
  EXPECT_TRUE(other.converged);
  EXPECT_LE((other.beta - cold.beta).norm(), std::sqrt(2e-8 * cold.gap.primal));
}

TEST(CoordinateDescentTest, AStartOnExcludedOrEmptyColumnsIsDropped) {
  std::mt19937_64 random(4);
  Eigen::MatrixXd X = RandomMatrix(4, 20, random);
  X.row(2).setZero();
  const ExplicitLasso problem(X, RandomVector(20, random),
                              Eigen::Vector4d(1.0, kInfinity, 1.0, 1.0));
  const CoordinateDescentSummary summary =
      Solve(problem, 0.01, {}, Eigen::Vector4d::Ones());
  EXPECT_TRUE(summary.converged);
  EXPECT_EQ(summary.beta(1), 0.0);
  EXPECT_EQ(summary.beta(2), 0.0);
  EXPECT_LE(summary.gap.Relative(), 1e-9);
}

TEST(CoordinateDescentTest, SaysWhenItDoesNotConverge) {
  const ExplicitLasso problem = Collinear(30, 400, 5);
  const CoordinateDescentSummary summary =
      Solve(problem, 1e-5 * problem.objective.LambdaMax(), {.max_sweeps = 10});
  EXPECT_FALSE(summary.converged);
  EXPECT_EQ(summary.sweeps, 10);
  EXPECT_GT(summary.gap.Relative(), 1e-9);
}

// The last sweep allowed counts like any other.
TEST(CoordinateDescentTest, SweepsThatRunAwayEndWhereTheyBegan) {
  Eigen::MatrixXd indefinite(2, 2);
  indefinite << 1.0, 2.0, 2.0, 1.0;
  LassoObjective objective;
  objective.gram = &indefinite;
  objective.correlation = Eigen::Vector2d(1.0, -1.0);
  objective.response_square = 4.0;
  objective.weights = Eigen::Vector2d::Ones();
  const Eigen::Vector2d start(0.5, 0.25);
  for (const auto stop : {CoordinateDescentOptions::Stop::kDualityGap,
                          CoordinateDescentOptions::Stop::kRelativeChange}) {
    CoordinateDescentOptions options;
    options.stop = stop;
    const auto summary = SolveCoordinateDescent(objective, 0.1, start, options);
    ASSERT_TRUE(summary.ok());
    EXPECT_FALSE(summary->converged);
    EXPECT_EQ(summary->beta, start);
    EXPECT_TRUE(std::isfinite(summary->gap.Relative()));
  }
}

TEST(CoordinateDescentTest, ConvergesWithinTheLastSweeps) {
  std::mt19937_64 random(6);
  const ExplicitLasso problem(RandomMatrix(5, 100, random),
                              RandomVector(100, random));
  const double lambda = 0.1 * problem.objective.LambdaMax();
  // 5 sweeps do on nearly orthogonal columns, and no check falls on the fifth.
  const CoordinateDescentSummary summary =
      Solve(problem, lambda, {.tolerance = 1e-4, .max_sweeps = 5});
  EXPECT_LE(summary.gap.Relative(), 1e-4);
  EXPECT_TRUE(summary.converged);
}

TEST(CoordinateDescentTest, RefusesBadInput) {
  const ExplicitLasso problem = Collinear(3, 20, 1);
  const auto message = [&](double lambda, const Eigen::VectorXd& start,
                           const CoordinateDescentOptions& options) {
    const auto summary =
        SolveCoordinateDescent(problem.objective, lambda, start, options);
    EXPECT_EQ(summary.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(summary.status().message());
  };
  EXPECT_THAT(message(-1.0, {}, {}), HasSubstr("λ is -1"));
  EXPECT_THAT(message(std::nan(""), {}, {}), HasSubstr("λ is nan"));
  EXPECT_THAT(message(kInfinity, {}, {}), HasSubstr("λ is inf"));
  EXPECT_THAT(message(1.0, Eigen::VectorXd::Zero(2), {}),
              HasSubstr("the start has 2 entries, the problem 3"));
  EXPECT_THAT(message(1.0, {}, {.tolerance = 0.0}),
              HasSubstr("tolerance is 0"));
  EXPECT_THAT(message(1.0, {}, {.tolerance = std::nan("")}),
              HasSubstr("tolerance is nan"));
  EXPECT_THAT(message(1.0, {}, {.max_sweeps = 0}),
              HasSubstr("max_sweeps is 0"));
  EXPECT_THAT(message(1.0, Eigen::Vector3d(0.0, std::nan(""), 0.0), {}),
              HasSubstr("start"));
  EXPECT_FALSE(SolveCoordinateDescent(LassoObjective(), 1.0, {}, {}).ok());
}

}  // namespace
}  // namespace mle
