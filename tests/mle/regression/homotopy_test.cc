// The path as a whole: its optimality on every kind of problem, and how it must
// change when the problem does.

#include "mle/regression/homotopy.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "Eigen/Cholesky"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/regression/coordinate_descent.h"
#include "mle/regression/duality_gap.h"
#include "tests/mle/regression/explicit_lasso.h"
#include "tests/mle/regression/path_check.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

HomotopySummary SolveByHomotopy(const ExplicitLasso& problem,
                                const HomotopyOptions& options = {}) {
  const auto summary = SolveHomotopy(problem.objective, options);
  EXPECT_TRUE(summary.ok()) << summary.status();
  return *summary;
}

ExplicitLasso WellConditioned(int n, int rows, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Eigen::MatrixXd X = RandomMatrix(n, rows, random);
  return ExplicitLasso(X, RandomVector(rows, random));
}

// The response to white noise of a slow second-order system, and its lags
// beside those of the input: as collinear as a process's record.
ExplicitLasso Lagged(int order, int rows, double noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Eigen::VectorXd u = RandomVector(rows + order, random);
  const Eigen::VectorXd v = noise * RandomVector(rows + order, random);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(rows + order);
  for (int k = 2; k < y.size(); ++k) {
    y(k) =
        1.9 * y(k - 1) - 0.903 * y(k - 2) + 0.01 * u(k - 1) + 0.005 * u(k - 2);
  }
  const Eigen::VectorXd measured = y + v;
  Eigen::MatrixXd X(2 * order, rows);
  for (int lag = 1; lag <= order; ++lag) {
    X.row(2 * lag - 2) = measured.segment(order - lag, rows);
    X.row(2 * lag - 1) = u.segment(order - lag, rows);
  }
  return ExplicitLasso(X, measured.tail(rows));
}

TEST(HomotopyTest, SolvesWellConditionedProblems) {
  for (int seed = 0; seed < 20; ++seed) {
    ExpectSolves(WellConditioned(30, 100, seed));
  }
}

TEST(HomotopyTest, SolvesCollinearLaggedProblems) {
  ExpectSolves(Lagged(60, 800, 0.03, 1));
  ExpectSolves(Lagged(60, 800, 1e-4, 2));
}

TEST(HomotopyTest, SolvesWideProblems) {
  for (int seed = 0; seed < 10; ++seed) {
    const HomotopySummary summary = ExpectSolves(WellConditioned(60, 20, seed));
    EXPECT_LE(summary.max_active, 20);
  }
}

// Without noise the data fit exactly and the Gram matrix has the rank of the
// system's state and inputs only.
TEST(HomotopyTest, SolvesNoiseFreeAutoregressiveData) {
  ExpectSolves(Lagged(20, 400, 0.0, 3));
  ExpectSolves(Lagged(60, 800, 0.0, 4));
}

TEST(HomotopyTest, SolvesWithFortyTwins) {
  std::mt19937_64 random(5);
  Eigen::MatrixXd X = RandomMatrix(80, 100, random);
  X.bottomRows(40) = X.topRows(40);
  ExpectSolves(ExplicitLasso(X, RandomVector(100, random)));
  // Opposites, and forty of the same.
  X.bottomRows(40) = -X.topRows(40);
  ExpectSolves(ExplicitLasso(X, RandomVector(100, random)));
  for (int j = 0; j < 40; ++j) X.row(2 * j) = X.row(0);
  ExpectSolves(ExplicitLasso(X, RandomVector(100, random)));
}

TEST(HomotopyTest, SolvesWithColumnsDependentThroughThreeOthers) {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 10; ++trial) {
    Eigen::MatrixXd X = RandomMatrix(40, 100, random);
    for (int j = 30; j < 40; ++j) {
      X.row(j) = X.row(j - 30) + X.row(j - 20) - X.row(j - 10);
      if (trial % 2 == 1) X.row(j) /= 3.0;
    }
    ExpectSolves(ExplicitLasso(X, RandomVector(100, random)));
  }
}

// Coefficients that reach the bound together and fit the data exactly together.
TEST(HomotopyTest, SolvesIntegerDataWithTies) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 40; ++trial) {
    Eigen::MatrixXd X(12, 16);
    for (double& x : X.reshaped()) x = static_cast<int>(random() % 3) - 1;
    Eigen::VectorXd e(16);
    for (double& value : e) value = static_cast<int>(random() % 5) - 2;
    ExpectSolves(ExplicitLasso(X, e));
  }
}

// Readings of few digits, as historians keep them.
TEST(HomotopyTest, SolvesQuantisedData) {
  ExplicitLasso exact = Lagged(30, 500, 0.03, 8);
  const Eigen::MatrixXd X = (exact.X * 20.0).array().round() / 20.0;
  const Eigen::VectorXd e = (exact.e * 20.0).array().round() / 20.0;
  ExpectSolves(ExplicitLasso(X, e));
}

TEST(HomotopyTest, SolvesWithWeightsOfEveryKind) {
  std::mt19937_64 random(9);
  for (int trial = 0; trial < 30; ++trial) {
    const Eigen::MatrixXd X = RandomMatrix(25, 60, random);
    Eigen::VectorXd weights(25);
    for (double& w : weights) {
      const int draw = static_cast<int>(random() % 8);
      w = draw == 0 ? 0.0 : draw == 1 ? kInfinity : 0.3 * draw;
    }
    const HomotopySummary summary =
        ExpectSolves(ExplicitLasso(X, RandomVector(60, random), weights));
    for (int j = 0; j < 25; ++j) {
      const double value = summary.path.Coefficients(0.0)(j);
      EXPECT_EQ(value == 0.0, weights(j) == kInfinity);
    }
  }
}

TEST(HomotopyTest, OneRegressorIsShrunk) {
  Eigen::MatrixXd X(1, 4);
  X << 1.0, -1.0, 2.0, 0.0;
  const ExplicitLasso problem(X, Eigen::Vector4d(3.0, 1.0, 1.0, 5.0));
  // G = 6/4, C = 4/4.
  const HomotopySummary summary = ExpectSolves(problem);
  EXPECT_EQ(summary.path.lambda_begin(), 1.0);
  for (const double lambda : {0.0, 0.25, 0.9, 1.0, 3.0}) {
    EXPECT_NEAR(summary.path.Coefficients(lambda)(0),
                std::max(1.0 - lambda, 0.0) / 1.5, 1e-15);
  }
}

TEST(HomotopyTest, NothingToExplainIsZeroEverywhere) {
  std::mt19937_64 random(10);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(5);
  for (const double first : {1.0, 0.0}) {
    weights(0) = first;
    const ExplicitLasso problem(RandomMatrix(5, 20, random),
                                Eigen::VectorXd::Zero(20), weights);
    HomotopyOptions options;
    options.certify_at = Eigen::Vector3d(0.0, 1e-6, 1.0);
    const HomotopySummary summary = SolveByHomotopy(problem, options);
    EXPECT_EQ(summary.termination, HomotopyTermination::kReachedLambdaMin);
    EXPECT_EQ(summary.relative_gap, Eigen::Vector3d::Zero());
    for (const double lambda : {0.0, 1e-6, 1.0}) {
      EXPECT_EQ(summary.path.Coefficients(lambda), Eigen::VectorXd::Zero(5));
    }
  }
}

TEST(HomotopyTest, IsZeroFromLambdaMaxOnAndNotBelow) {
  const ExplicitLasso problem = WellConditioned(20, 50, 11);
  const HomotopySummary summary = SolveByHomotopy(problem);
  const double lambda_max = problem.objective.LambdaMax();
  EXPECT_EQ(summary.path.lambda_begin(), lambda_max);
  EXPECT_TRUE(summary.path.Coefficients(lambda_max).isZero(0.0));
  EXPECT_TRUE(summary.path.Coefficients(100.0 * lambda_max).isZero(0.0));
  EXPECT_GT(summary.path.Coefficients(0.999 * lambda_max).norm(), 0.0);
}

// However large λ, it does not act on them.
TEST(HomotopyTest, UnpenalisedCoefficientsAreLeastSquaresAboveLambdaMax) {
  std::mt19937_64 random(12);
  const Eigen::MatrixXd X = RandomMatrix(6, 30, random);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(6);
  weights(1) = weights(4) = 0.0;
  const ExplicitLasso problem(X, RandomVector(30, random), weights);
  const Eigen::MatrixXd F = X(std::vector<int>{1, 4}, Eigen::all).transpose();
  const Eigen::Vector2d expected =
      (F.transpose() * F).ldlt().solve(F.transpose() * problem.e);
  HomotopyOptions options;
  options.certify_at = Eigen::Vector3d(0.01, 10.0, 1e6);
  const HomotopySummary summary = SolveByHomotopy(problem, options);
  EXPECT_LE(summary.MaxRelativeGap(), 1e-12);
  for (const double lambda : {10.0, 1e6, 1e200}) {
    const Eigen::VectorXd beta = summary.path.Coefficients(lambda);
    EXPECT_NEAR(beta(1), expected(0), 1e-13);
    EXPECT_NEAR(beta(4), expected(1), 1e-13);
    EXPECT_EQ((beta.array() != 0.0).count(), 2);
  }
}

// Where they explain everything, what is left is rounding.
TEST(HomotopyTest, UnpenalisedCoefficientsMayExplainEverything) {
  std::mt19937_64 random(13);
  const Eigen::MatrixXd X = RandomMatrix(8, 30, random);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(8);
  weights.head(3).setZero();
  const Eigen::Vector3d beta(1.0, -2.0, 3.0);
  const ExplicitLasso problem(X, X.topRows(3).transpose() * beta, weights);
  HomotopyOptions options;
  options.certify_at = Eigen::Vector4d(0.0, 1e-9, 1e-3, 1.0);
  const HomotopySummary summary = SolveByHomotopy(problem, options);
  EXPECT_EQ(summary.termination, HomotopyTermination::kReachedLambdaMin);
  EXPECT_LE(summary.MaxRelativeGap(), 1e-9);
  for (const double lambda : {0.0, 1e-9, 1.0}) {
    EXPECT_TRUE(
        summary.path.Coefficients(lambda).head(3).isApprox(beta, 1e-12));
    EXPECT_TRUE(summary.path.Coefficients(lambda).tail(5).isZero(1e-12));
  }
}

TEST(HomotopyTest, EndsInLeastSquares) {
  const ExplicitLasso problem = WellConditioned(30, 80, 14);
  const Eigen::VectorXd expected =
      problem.gram->ldlt().solve(problem.objective.correlation);
  // cond(G) is about 20.
  EXPECT_TRUE(SolveByHomotopy(problem).path.Coefficients(0.0).isApprox(expected,
                                                                       1e-12));
}

// Where least squares has many solutions, the end has the least Σ|β|: of twins
// of different length only the longer is used.
TEST(HomotopyTest, EndsInTheLeastNormOfItsKind) {
  std::mt19937_64 random(15);
  Eigen::MatrixXd X = RandomMatrix(6, 40, random);
  X.bottomRows(3) = 2.0 * X.topRows(3);
  const ExplicitLasso problem(X, RandomVector(40, random));
  const Eigen::VectorXd beta = ExpectSolves(problem).path.Coefficients(0.0);
  const Eigen::VectorXd expected =
      problem.gram->bottomRightCorner(3, 3).ldlt().solve(
          problem.objective.correlation.tail(3));
  EXPECT_TRUE(beta.tail(3).isApprox(expected, 1e-12));
  EXPECT_TRUE(beta.head(3).isZero(0.0));
}

TEST(HomotopyTest, ThePathIsContinuous) {
  for (const ExplicitLasso& problem :
       {WellConditioned(40, 100, 16), Lagged(40, 500, 0.03, 17)}) {
    const LassoPath path = SolveByHomotopy(problem).path;
    for (std::size_t i = 1; i < path.segments().size(); ++i) {
      const auto& before = path.segments()[i - 1];
      const auto& after = path.segments()[i];
      ASSERT_EQ(before.lambda_end, after.lambda_begin);
      Eigen::VectorXd end = Eigen::VectorXd::Zero(path.size());
      Eigen::VectorXd begin = end;
      end(path.Active(before)) =
          path.Start(before) +
          (before.lambda_begin - before.lambda_end) * path.Slope(before);
      begin(path.Active(after)) = path.Start(after);
      // Between them lies one refinement, of the rounding of c by G⁻¹.
      EXPECT_LE((end - begin).cwiseAbs().maxCoeff(),
                1e-8 * std::max(begin.cwiseAbs().maxCoeff(), 1e-3));
    }
  }
}

TEST(HomotopyTest, TheResponsesUnitScalesThePath) {
  const ExplicitLasso problem = Lagged(20, 300, 0.03, 18);
  const LassoPath path = SolveByHomotopy(problem).path;
  for (const double unit : {0.25, 1024.0, 1e-9, 1e9}) {
    const ExplicitLasso scaled(problem.X, unit * problem.e);
    const LassoPath other = SolveByHomotopy(scaled).path;
    const bool exact = unit == 0.25 || unit == 1024.0;
    for (const double part : {0.5, 1e-2, 1e-4}) {
      const double lambda = part * path.lambda_begin();
      const Eigen::VectorXd expected = unit * path.Coefficients(lambda);
      // Powers of two change no rounding; others move events by theirs, which
      // the condition of the lags (1e4 at most here) makes larger.
      EXPECT_TRUE(other.Coefficients(unit * lambda)
                      .isApprox(expected, exact ? 0.0 : 1e-9))
          << unit;
    }
  }
}

// A weight's unit is λ's.
TEST(HomotopyTest, TheWeightsUnitScalesLambda) {
  const ExplicitLasso problem = Lagged(20, 300, 0.03, 19);
  const LassoPath path = SolveByHomotopy(problem).path;
  for (const double unit : {std::pow(2.0, -40), std::pow(2.0, 40)}) {
    const ExplicitLasso scaled(problem.X, problem.e,
                               Eigen::VectorXd::Constant(40, unit));
    const HomotopySummary summary = SolveByHomotopy(scaled);
    EXPECT_EQ(summary.termination, HomotopyTermination::kReachedLambdaMin);
    for (const double part : {0.5, 1e-2, 1e-4, 1e-6}) {
      const double lambda = part * path.lambda_begin();
      EXPECT_EQ(summary.path.Coefficients(lambda / unit),
                path.Coefficients(lambda));
    }
  }
}

TEST(HomotopyTest, TheOrderOfTheColumnsDoesNotMatter) {
  const ExplicitLasso problem = Lagged(20, 300, 0.03, 20);
  std::vector<int> order(40);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937_64 random(21);
  std::shuffle(order.begin(), order.end(), random);
  const ExplicitLasso permuted(problem.X(order, Eigen::all), problem.e);
  const LassoPath path = SolveByHomotopy(problem).path;
  const LassoPath other = SolveByHomotopy(permuted).path;
  for (const double part : {0.5, 1e-2, 1e-4, 0.0}) {
    const double lambda = part * path.lambda_begin();
    const Eigen::VectorXd expected = path.Coefficients(lambda)(order);
    EXPECT_TRUE(other.Coefficients(lambda).isApprox(expected, 1e-9)) << part;
  }
}

TEST(HomotopyTest, StopsAtLambdaMin) {
  const ExplicitLasso problem = WellConditioned(20, 60, 22);
  const LassoPath whole = SolveByHomotopy(problem).path;
  HomotopyOptions options;
  options.lambda_min = 0.1 * whole.lambda_begin();
  const HomotopySummary summary = SolveByHomotopy(problem, options);
  EXPECT_EQ(summary.termination, HomotopyTermination::kReachedLambdaMin);
  EXPECT_DOUBLE_EQ(summary.path.lambda_end(), options.lambda_min);
  EXPECT_LT(summary.path.segments().size(), whole.segments().size());
  for (const double part : {0.9, 0.5, 0.1}) {
    const double lambda = part * whole.lambda_begin();
    EXPECT_TRUE(summary.path.Coefficients(lambda).isApprox(
        whole.Coefficients(lambda), 1e-14));
  }
  options.lambda_min = 2.0 * whole.lambda_begin();
  EXPECT_TRUE(SolveByHomotopy(problem, options).path.segments().empty());
}

TEST(HomotopyTest, CertifiesThePlaceWhereItStops) {
  const ExplicitLasso problem = WellConditioned(20, 60, 23);
  HomotopyOptions options;
  options.max_active = 5;
  const double end = SolveByHomotopy(problem, options).path.lambda_end();
  options.certify_at = Eigen::VectorXd{{0.5 * end, end, end, 1.5 * end}};
  const HomotopySummary summary = SolveByHomotopy(problem, options);
  EXPECT_EQ(summary.path.lambda_end(), end);
  EXPECT_EQ(summary.relative_gap(0), std::numeric_limits<double>::infinity());
  EXPECT_LE(summary.relative_gap.tail(3).maxCoeff(), 1e-12);
}

TEST(HomotopyTest, StopsBeforeMoreAreActiveThanAllowed) {
  const ExplicitLasso problem = WellConditioned(20, 60, 23);
  const LassoPath whole = SolveByHomotopy(problem).path;
  HomotopyOptions options;
  options.max_active = 5;
  options.certify_at =
      LambdaGrid(whole.lambda_begin(), 1e-3, 50, /*with_zero=*/true);
  const HomotopySummary summary = SolveByHomotopy(problem, options);
  EXPECT_EQ(summary.termination, HomotopyTermination::kReachedMaxActive);
  EXPECT_EQ(summary.max_active, 5);
  EXPECT_GT(summary.path.lambda_end(), 0.0);
  EXPECT_THAT(summary.BriefReport(), HasSubstr("largest active set"));
  for (Eigen::Index i = 0; i < options.certify_at.size(); ++i) {
    const double lambda = options.certify_at(i);
    EXPECT_EQ(std::isfinite(summary.relative_gap(i)),
              lambda >= summary.path.lambda_end());
    if (lambda < summary.path.lambda_end()) continue;
    EXPECT_TRUE(summary.path.Coefficients(lambda).isApprox(
        whole.Coefficients(lambda), 1e-14));
  }
}

// The gaps computed on the way are those of the path's own solutions.
TEST(HomotopyTest, CertificatesEqualDirectGaps) {
  for (const ExplicitLasso& problem :
       {WellConditioned(30, 100, 24), WellConditioned(50, 20, 25),
        Lagged(40, 500, 0.03, 26)}) {
    HomotopyOptions options;
    options.certify_at = LambdaGrid(2.0 * problem.objective.LambdaMax(), 1e-7,
                                    300, /*with_zero=*/true);
    const HomotopySummary summary = SolveByHomotopy(problem, options);
    for (Eigen::Index i = 0; i < options.certify_at.size(); ++i) {
      const double lambda = options.certify_at(i);
      const Eigen::VectorXd beta = summary.path.Coefficients(lambda);
      const double direct =
          ComputeDualityGap(problem.objective, lambda, beta).Relative();
      // Either may be the more accurate one.
      EXPECT_NEAR(summary.relative_gap(i), direct,
                  GapTolerance(problem.objective, lambda, beta))
          << "λ = " << lambda;
    }
    EXPECT_EQ(summary.MaxRelativeGap(), summary.relative_gap.maxCoeff());
  }
}

TEST(HomotopyTest, AgreesWithCoordinateDescent) {
  for (const ExplicitLasso& problem :
       {WellConditioned(30, 100, 27), WellConditioned(30, 60, 28)}) {
    const LassoPath path = SolveByHomotopy(problem).path;
    for (const double part : {0.8, 0.3, 0.05, 1e-3}) {
      const double lambda = part * path.lambda_begin();
      // With a gap of 1e-22 the coefficients are right to √(2·1e-22 / least
      // eigenvalue), some 1e-10.
      const auto other = SolveCoordinateDescent(problem.objective, lambda, {},
                                                {.tolerance = 1e-22});
      ASSERT_TRUE(other.ok());
      EXPECT_LE((other->beta - path.Coefficients(lambda)).norm(),
                1e-9 * other->beta.norm());
    }
  }
}

TEST(HomotopyTest, RefusesBadInput) {
  const ExplicitLasso problem = WellConditioned(3, 10, 29);
  const auto message = [&](const HomotopyOptions& options) {
    const auto summary = SolveHomotopy(problem.objective, options);
    EXPECT_EQ(summary.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(summary.status().message());
  };
  HomotopyOptions options;
  options.lambda_min = -1.0;
  EXPECT_THAT(message(options), HasSubstr("lambda_min is -1"));
  options.lambda_min = std::nan("");
  EXPECT_THAT(message(options), HasSubstr("lambda_min is nan"));
  options = {};
  options.max_active = 0;
  EXPECT_THAT(message(options), HasSubstr("max_active is 0"));
  options = {};
  options.certify_at = Eigen::Vector2d(1.0, 0.5);
  EXPECT_THAT(message(options), HasSubstr("certify_at[1] is 0.5"));
  options.certify_at = Eigen::Vector2d(-1.0, 0.5);
  EXPECT_THAT(message(options), HasSubstr("certify_at[0] is -1"));
  EXPECT_FALSE(SolveHomotopy(LassoObjective(), {}).ok());
}

}  // namespace
}  // namespace mle
