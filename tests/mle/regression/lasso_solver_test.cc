#include "mle/regression/lasso_solver.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/regression/duality_gap.h"
#include "tests/mle/regression/degenerate_lasso.h"
#include "tests/mle/regression/explicit_lasso.h"
#include "tests/mle/regression/path_check.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

LassoSolution SolveAsAsked(const ExplicitLasso& problem,
                           const Eigen::VectorXd& lambdas, LassoSolver solver) {
  LassoSolverOptions options;
  options.solver = solver;
  const auto solution = SolveLasso(problem.objective, lambdas, options);
  EXPECT_TRUE(solution.ok()) << solution.status();
  return *solution;
}

// The gaps reported are those of the path at the λ asked for.
void ExpectCertified(const ExplicitLasso& problem,
                     const LassoSolution& solution) {
  for (Eigen::Index i = 0; i < solution.lambdas.size(); ++i) {
    const double lambda = solution.lambdas(i);
    const Eigen::VectorXd beta = solution.path.Coefficients(lambda);
    EXPECT_NEAR(solution.relative_gap(i),
                ComputeDualityGap(problem.objective, lambda, beta).Relative(),
                GapTolerance(problem.objective, lambda, beta));
  }
}

TEST(LassoSolverTest, BothSolversAgree) {
  std::mt19937_64 random(1);
  for (const bool weighted : {false, true}) {
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(15);
    if (weighted) {
      weights(2) = 0.0;
      weights(3) = std::numeric_limits<double>::infinity();
      weights(4) = 3.0;
    }
    const ExplicitLasso problem(RandomMatrix(15, 60, random),
                                RandomVector(60, random), weights);
    // Above λ_max and down to 0.
    const Eigen::VectorXd lambdas = LambdaGrid(
        3.0 * problem.objective.LambdaMax(), 1e-4, 30, /*with_zero=*/true);
    const LassoSolution exact =
        SolveAsAsked(problem, lambdas, LassoSolver::kHomotopy);
    const LassoSolution descent =
        SolveAsAsked(problem, lambdas, LassoSolver::kCoordinateDescent);
    EXPECT_LE(exact.MaxRelativeGap(), 1e-11);
    EXPECT_LE(descent.MaxRelativeGap(), 1e-9);
    EXPECT_THAT(exact.report, HasSubstr("homotopy: complete"));
    EXPECT_THAT(descent.report, HasSubstr("31 values of λ, 0 not converged"));
    ExpectCertified(problem, exact);
    ExpectCertified(problem, descent);
    for (const double lambda : lambdas) {
      // A gap of 1e-9 of the primal value, at most 1, is an error of
      // √(2·1e-9/least eigenvalue of G), here 0.2, in the coefficients.
      EXPECT_LE(
          (exact.path.Coefficients(lambda) - descent.path.Coefficients(lambda))
              .norm(),
          1e-4)
          << "λ = " << lambda << (weighted ? ", weighted" : "");
    }
  }
}

// Two coefficients shrink to nothing along the last segment, for the third
// regressor explains everything. What rounding of their larger values leaves,
// seen through the square of a sample that both regressors share, is more than
// λ.
TEST(LassoSolverTest, CertifiesTheCoefficientsAsRounded) {
  for (const double spike : {1e3, 1e5, 1e7}) {
    const Eigen::MatrixXd regressors{
        {spike, 2.1, 1.7}, {spike, -1.9, -1.3}, {0.0, 1.1, 0.0}};
    const Eigen::VectorXd response{{0.0, 1e6, 0.0}};
    const ExplicitLasso problem(regressors, response);
    const Eigen::VectorXd lambdas =
        LambdaGrid(problem.objective.LambdaMax(), 1e-8, 9, /*with_zero=*/false);
    const LassoSolution solution =
        SolveAsAsked(problem, lambdas, LassoSolver::kHomotopy);
    ExpectCertified(problem, solution);
    for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
      const Eigen::VectorXd beta = solution.path.Coefficients(lambdas(i));
      const double tolerance =
          GapTolerance(problem.objective, lambdas(i), beta);
      EXPECT_LE(solution.relative_gap(i), tolerance);
      const LassoSolution alone =
          SolveAsAsked(problem, lambdas.segment(i, 1), LassoSolver::kHomotopy);
      ExpectCertified(problem, alone);
      EXPECT_LE(alone.relative_gap(0), tolerance);
    }
  }
}

// Between the values of its grid coordinate descent interpolates, from zero at
// λ_max.
TEST(LassoSolverTest, CoordinateDescentGivesAContinuousPath) {
  std::mt19937_64 random(2);
  const ExplicitLasso problem(RandomMatrix(10, 40, random),
                              RandomVector(40, random));
  const double lambda_max = problem.objective.LambdaMax();
  const LassoSolution solution = SolveAsAsked(
      problem, LambdaGrid(0.5 * lambda_max, 1e-2, 8, /*with_zero=*/true),
      LassoSolver::kCoordinateDescent);
  const LassoPath& path = solution.path;
  EXPECT_EQ(path.lambda_begin(), lambda_max);
  EXPECT_EQ(path.lambda_end(), 0.0);
  for (std::size_t i = 0; i < path.segments().size(); ++i) {
    const auto& segment = path.segments()[i];
    if (i > 0) {
      EXPECT_EQ(segment.lambda_begin, path.segments()[i - 1].lambda_end);
    }
    const Eigen::VectorXd middle =
        path.Coefficients(0.5 * (segment.lambda_begin + segment.lambda_end));
    EXPECT_TRUE(middle.isApprox(0.5 * (path.Coefficients(segment.lambda_begin) +
                                       path.Coefficients(segment.lambda_end)),
                                1e-13));
  }
}

// Problems that the homotopy gives up on are so small at its end that only
// rounding is left; what it leaves is filled all the same.
TEST(LassoSolverTest, EveryLambdaIsSolvedOnDegenerateProblems) {
  DegenerateLassoGenerator generator(21);
  for (int number = 0; number < 300; ++number) {
    const ExplicitLasso problem = generator.Next();
    const double lambda_max = problem.objective.LambdaMax();
    if (lambda_max == 0.0) continue;
    const LassoSolution solution = SolveAsAsked(
        problem, LambdaGrid(lambda_max, 1e-3, 6, /*with_zero=*/true),
        LassoSolver::kHomotopy);
    for (Eigen::Index i = 1; i < solution.lambdas.size(); ++i) {
      const double lambda = solution.lambdas(i);
      EXPECT_LE(solution.relative_gap(i),
                GapTolerance(problem.objective, lambda,
                             solution.path.Coefficients(lambda)))
          << "problem " << number << ": " << solution.report;
    }
    // Exact fits have a primal value of nothing.
    EXPECT_LE(solution.relative_gap(0), 1e-2)
        << "problem " << number << ": " << solution.report;
  }
}

// Where two segments meet the path is what the second begins with, to the bit:
// zero stays zero.
TEST(LassoPathTest, IsExactWhereSegmentsMeet) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const double end = std::uniform_real_distribution(0.1, 0.9)(random);
    const Eigen::VectorXd begin = RandomVector(4, random);
    Eigen::VectorXd knot = RandomVector(4, random);
    knot(trial % 4) = 0.0;
    LassoPath path(4);
    path.AppendJoin(1.0, begin, end, knot);
    EXPECT_EQ(path.Coefficients(end), knot);
    EXPECT_EQ(path.Coefficients(0.01), knot);
    path.AppendJoin(end, knot, 0.05, RandomVector(4, random));
    EXPECT_EQ(path.Coefficients(1.0), begin);
    EXPECT_EQ(path.Coefficients(end), knot);
  }
}

TEST(LassoSolverTest, OneLambdaIsEnough) {
  std::mt19937_64 random(3);
  const ExplicitLasso problem(RandomMatrix(10, 40, random),
                              RandomVector(40, random));
  for (const double part : {0.0, 0.1, 1.0, 5.0}) {
    const Eigen::VectorXd lambda =
        Eigen::VectorXd::Constant(1, part * problem.objective.LambdaMax());
    for (const LassoSolver solver :
         {LassoSolver::kHomotopy, LassoSolver::kCoordinateDescent}) {
      const LassoSolution solution = SolveAsAsked(problem, lambda, solver);
      ASSERT_EQ(solution.relative_gap.size(), 1);
      EXPECT_LE(solution.MaxRelativeGap(), 1e-9);
      ExpectCertified(problem, solution);
    }
  }
}

TEST(LassoSolverTest, RefusesBadInput) {
  std::mt19937_64 random(4);
  const ExplicitLasso problem(RandomMatrix(3, 10, random),
                              RandomVector(10, random));
  const auto message = [&](const LassoObjective& objective,
                           const Eigen::VectorXd& lambdas,
                           const LassoSolverOptions& options) {
    const auto solution = SolveLasso(objective, lambdas, options);
    EXPECT_EQ(solution.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(solution.status().message());
  };
  EXPECT_THAT(message(problem.objective, {}, {}),
              HasSubstr("grid of λ is empty"));
  EXPECT_THAT(message(LassoObjective(), Eigen::VectorXd::Ones(1), {}),
              HasSubstr("0 × 0"));
  for (const LassoSolver solver :
       {LassoSolver::kHomotopy, LassoSolver::kCoordinateDescent}) {
    LassoSolverOptions options;
    options.solver = solver;
    EXPECT_THAT(message(problem.objective, Eigen::Vector2d(0.2, 0.1), options),
                HasSubstr("0.1"));
    EXPECT_THAT(message(problem.objective, Eigen::Vector2d(-0.2, 0.1), options),
                HasSubstr("-0.2"));
    EXPECT_THAT(
        message(problem.objective, Eigen::Vector2d(0.1, std::nan("")), options),
        HasSubstr("nan"));
  }
  LassoSolverOptions options;
  options.solver = LassoSolver::kCoordinateDescent;
  options.coordinate_descent.tolerance = -1.0;
  EXPECT_THAT(message(problem.objective, Eigen::VectorXd::Ones(1), options),
              HasSubstr("tolerance is -1"));
  options.coordinate_descent.tolerance = 1e-9;
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message(problem.objective, Eigen::Vector2d(1.0, infinity), {}),
              HasSubstr("inf"));
}

}  // namespace
}  // namespace mle
