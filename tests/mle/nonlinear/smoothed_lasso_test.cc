#include "mle/nonlinear/smoothed_lasso.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/regression/homotopy.h"
#include "tests/mle/regression/degenerate_lasso.h"
#include "tests/mle/regression/explicit_lasso.h"
#include "tests/mle/regression/lagged_lasso.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

SmoothedLassoSummary Solve(const LassoObjective& objective, double lambda,
                           const Eigen::VectorXd& start = {},
                           const SmoothedLassoOptions& options = {}) {
  const auto summary = SolveSmoothedLasso(objective, lambda, start, options);
  EXPECT_TRUE(summary.ok()) << summary.status();
  return *summary;
}

Eigen::VectorXd Exact(const LassoObjective& objective, double lambda) {
  const auto summary = SolveHomotopy(objective, {});
  EXPECT_TRUE(summary.ok()) << summary.status();
  return summary->path.Coefficients(lambda);
}

// Orthonormal regressors: β_j = S(C_j, λw_j).
TEST(SmoothedLassoTest, SoftThresholdsOrthonormalRegressors) {
  const Eigen::MatrixXd gram = Eigen::MatrixXd::Identity(6, 6);
  LassoObjective objective;
  objective.gram = &gram;
  objective.correlation.resize(6);
  objective.correlation << 0.9, -0.5, 0.1, 0.3, -0.8, 0.7;
  objective.response_square = 4.0;
  objective.weights.resize(6);
  objective.weights << 1.0, 2.0, 1.0, 1.0, 0.0, kInfinity;
  const SmoothedLassoSummary fit = Solve(objective, 0.2);
  Eigen::VectorXd expected(6);
  expected << 0.7, -0.1, 0.0, 0.1, -0.8, 0.0;
  EXPECT_EQ(fit.termination, SmoothedLassoTermination::kConverged);
  EXPECT_LE((fit.beta - expected).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(fit.beta(2), 0.0);
  EXPECT_EQ(fit.beta(5), 0.0);
  EXPECT_EQ(fit.num_nonzero, 4);
}

TEST(SmoothedLassoTest, IsZeroFromLambdaMaxOn) {
  std::mt19937_64 random(1);
  const ExplicitLasso problem(RandomMatrix(12, 50, random),
                              RandomVector(50, random));
  const double top = problem.objective.LambdaMax();
  const SmoothedLassoSummary above = Solve(problem.objective, top * 1.0001);
  EXPECT_TRUE(above.beta.isZero(0.0));
  EXPECT_EQ(above.gap.gap, 0.0);
  const SmoothedLassoSummary below = Solve(problem.objective, top * 0.999);
  EXPECT_EQ(below.num_nonzero, 1);
}

// On lags as collinear as records have them the answer is the exact one, also
// from a start that is far away, and the certificate is its own.
TEST(SmoothedLassoTest, AgreesWithTheExactPathOnLags) {
  LaggedLassoGenerator generator(5);
  int compared = 0;
  for (int i = 0; i < 40; ++i) {
    const ExplicitLasso problem = generator.Next();
    Eigen::VectorXd start;
    for (const double part : {0.3, 3e-2, 1e-3}) {
      const double lambda = part * problem.objective.LambdaMax();
      const SmoothedLassoSummary fit = Solve(problem.objective, lambda, start);
      EXPECT_EQ(fit.termination, SmoothedLassoTermination::kConverged)
          << "problem " << i << ", λ " << lambda << ": " << fit.BriefReport();
      EXPECT_LE(fit.gap.Relative(), 1e-9);
      EXPECT_EQ(fit.gap.gap,
                ComputeDualityGap(problem.objective, lambda, fit.beta).gap);
      // The gap bounds what the fits differ by: ½ ‖X̃(β − β*)‖²/N ≤ gap.
      const Eigen::VectorXd difference =
          fit.beta - Exact(problem.objective, lambda);
      EXPECT_LE(
          0.5 * difference.dot(*problem.gram * difference),
          2e-9 * fit.gap.primal + 1e-14 * problem.objective.response_square);
      start = fit.beta;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 120);
}

// Coefficients that are well determined are the exact ones, and none but those
// of the exact solution is other than zero.
TEST(SmoothedLassoTest, FindsTheExactSupport) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 10; ++i) {
    const ExplicitLasso problem(RandomMatrix(40, 100, random),
                                RandomVector(100, random));
    const double lambda = 0.2 * problem.objective.LambdaMax();
    const SmoothedLassoSummary fit = Solve(problem.objective, lambda);
    const Eigen::VectorXd exact = Exact(problem.objective, lambda);
    EXPECT_LE((fit.beta - exact).cwiseAbs().maxCoeff(), 1e-6);
    for (int j = 0; j < exact.size(); ++j) {
      EXPECT_EQ(fit.beta(j) != 0.0, exact(j) != 0.0) << "coefficient " << j;
    }
  }
}

// Twins, ties, zero columns, more columns than rows, weights of 0 and ∞.
TEST(SmoothedLassoTest, SolvesDegenerateProblems) {
  DegenerateLassoGenerator generator(3);
  for (int i = 0; i < 300; ++i) {
    const ExplicitLasso problem = generator.Next();
    const double top = problem.objective.LambdaMax();
    if (!(top > 0.0)) continue;
    const SmoothedLassoSummary fit = Solve(problem.objective, 0.1 * top);
    EXPECT_TRUE(fit.beta.allFinite());
    // Where the fit is exact but for the penalty the primal value is small, and
    // rounding of the sums is not.
    EXPECT_LE(fit.gap.gap,
              1e-8 * fit.gap.primal + 1e-13 * problem.objective.response_square)
        << "problem " << i << ": " << fit.BriefReport();
    for (int j = 0; j < fit.beta.size(); ++j) {
      if (!std::isfinite(problem.objective.weights(j))) {
        EXPECT_EQ(fit.beta(j), 0.0);
      }
    }
  }
}

// β(aλ; aC) = aβ(λ; C): also the smoothing must scale.
TEST(SmoothedLassoTest, ScalesWithTheResponse) {
  std::mt19937_64 random(4);
  const ExplicitLasso problem(RandomMatrix(30, 80, random),
                              RandomVector(80, random));
  const double lambda = 0.05 * problem.objective.LambdaMax();
  const SmoothedLassoSummary fit = Solve(problem.objective, lambda);
  for (const double factor : {1e-6, 1e6}) {
    LassoObjective scaled = problem.objective;
    scaled.correlation *= factor;
    scaled.response_square *= factor * factor;
    const SmoothedLassoSummary other = Solve(scaled, factor * lambda);
    EXPECT_EQ(other.termination, SmoothedLassoTermination::kConverged);
    EXPECT_LE((other.beta / factor - fit.beta).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_EQ(other.num_nonzero, fit.num_nonzero);
  }
}

TEST(SmoothedLassoTest, AtZeroPenaltyIsLeastSquares) {
  std::mt19937_64 random(6);
  const ExplicitLasso problem(RandomMatrix(8, 40, random),
                              RandomVector(40, random));
  const SmoothedLassoSummary fit = Solve(problem.objective, 0.0);
  const Eigen::VectorXd gradient =
      problem.objective.correlation - *problem.gram * fit.beta;
  EXPECT_LE(gradient.cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_EQ(fit.termination, SmoothedLassoTermination::kConverged);
}

// One stage at most: not converged, and says so with its true gap.
TEST(SmoothedLassoTest, ReportsWhatItDidNotReach) {
  std::mt19937_64 random(7);
  const ExplicitLasso problem(RandomMatrix(30, 80, random),
                              RandomVector(80, random));
  const double lambda = 0.01 * problem.objective.LambdaMax();
  const SmoothedLassoSummary fit =
      Solve(problem.objective, lambda, {}, {.max_stages = 1});
  EXPECT_EQ(fit.termination, SmoothedLassoTermination::kStageLimit);
  EXPECT_GT(fit.gap.Relative(), 1e-9);
  EXPECT_EQ(fit.solves, 1);
  EXPECT_THAT(fit.BriefReport(), HasSubstr("not converged"));
}

TEST(SmoothedLassoTest, NamesWhatIsInvalid) {
  std::mt19937_64 random(8);
  const ExplicitLasso problem(RandomMatrix(3, 10, random),
                              RandomVector(10, random));
  const auto message = [&](double lambda, const Eigen::VectorXd& start,
                           const SmoothedLassoOptions& options) {
    return std::string(
        SolveSmoothedLasso(problem.objective, lambda, start, options)
            .status()
            .message());
  };
  EXPECT_THAT(message(-1.0, {}, {}), HasSubstr("λ is -1"));
  EXPECT_THAT(message(std::nan(""), {}, {}), HasSubstr("λ is nan"));
  EXPECT_THAT(message(0.1, Eigen::VectorXd::Zero(2), {}),
              HasSubstr("the start has 2 coefficients, the problem 3"));
  EXPECT_THAT(message(0.1, Eigen::VectorXd::Constant(3, kInfinity), {}),
              HasSubstr("not finite"));
  EXPECT_THAT(message(0.1, {}, {.tolerance = 0.0}),
              HasSubstr("tolerance is 0, must be finite and positive"));
  EXPECT_THAT(message(0.1, {}, {.smoothing_decrease = 1.0}),
              HasSubstr("smoothing_decrease is 1"));
  EXPECT_THAT(message(0.1, {}, {.max_stages = 0}), HasSubstr("max_stages"));
  EXPECT_THAT(message(0.1, {}, {.max_iterations = 0}),
              HasSubstr("max_iterations"));
}

// As the solver of a whole grid: certified at every λ, most of which are
// interpolated between the knots.
TEST(SmoothedLassoTest, SolvesAGrid) {
  std::mt19937_64 random(9);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(15);
  weights(3) = 2.0;
  const ExplicitLasso problem(RandomMatrix(15, 60, random),
                              RandomVector(60, random), weights);
  const double top = problem.objective.LambdaMax();
  const Eigen::VectorXd lambdas =
      Eigen::VectorXd::LinSpaced(1001, 0.0, 1.2 * top);
  const auto solution =
      SolveLasso(problem.objective, lambdas, SmoothedLassoSolver({}));
  ASSERT_TRUE(solution.ok()) << solution.status();
  const auto exact = SolveHomotopy(problem.objective, {});
  ASSERT_TRUE(exact.ok());
  EXPECT_LE(solution->MaxRelativeGap(), 1e-9);
  for (Eigen::Index i = 0; i < lambdas.size(); i += 7) {
    const Eigen::VectorXd beta = solution->path.Coefficients(lambdas(i));
    EXPECT_LE(
        (beta - exact->path.Coefficients(lambdas(i))).cwiseAbs().maxCoeff(),
        1e-4)
        << "λ = " << lambdas(i);
    EXPECT_NEAR(
        solution->relative_gap(i),
        ComputeDualityGap(problem.objective, lambdas(i), beta).Relative(),
        1e-12);
  }
  EXPECT_THAT(solution->report, HasSubstr("of 1001 values of λ solved"));
}

}  // namespace
}  // namespace mle
