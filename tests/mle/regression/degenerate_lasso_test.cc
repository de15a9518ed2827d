// The path on thousands of small problems that are as degenerate as can be.

#include "tests/mle/regression/degenerate_lasso.h"

#include <cmath>
#include <cstdint>

#include "gtest/gtest.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/homotopy.h"
#include "mle/regression/lasso_solver.h"
#include "tests/mle/regression/path_check.h"

namespace mle {
namespace {

class DegenerateLassoTest : public ::testing::TestWithParam<int> {};

// Down to 1e-6 λ_max the path is right to its rounding, and what is certified
// is so.
TEST_P(DegenerateLassoTest, IsSolvedAtEveryLambda) {
  DegenerateLassoGenerator generator(GetParam());
  for (int number = 0; number < 400; ++number) {
    const ExplicitLasso problem = generator.Next();
    const double lambda_max = problem.objective.LambdaMax();
    if (lambda_max == 0.0) continue;
    HomotopyOptions options;
    options.certify_at = LambdaGrid(lambda_max, 1e-6, 20, /*with_zero=*/true);
    const auto summary = SolveHomotopy(problem.objective, options);
    ASSERT_TRUE(summary.ok()) << summary.status();
    // Where a tie or rounding stops it, that is below what is looked at.
    if (summary->termination != HomotopyTermination::kReachedLambdaMin) {
      EXPECT_LE(summary->path.lambda_end(), 1e-9 * lambda_max)
          << "problem " << number << ": " << summary->BriefReport();
    }
    for (Eigen::Index i = 1; i < options.certify_at.size(); ++i) {
      const double lambda = options.certify_at(i);
      const Eigen::VectorXd beta = summary->path.Coefficients(lambda);
      const double tolerance = GapTolerance(problem.objective, lambda, beta);
      EXPECT_LE(ComputeDualityGap(problem.objective, lambda, beta).Relative(),
                tolerance)
          << "problem " << number << ", λ = " << lambda / lambda_max
          << " λ_max; " << summary->BriefReport();
      EXPECT_LE(summary->relative_gap(i), tolerance) << "problem " << number;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, DegenerateLassoTest,
                         ::testing::Values(11, 12, 13, 14, 15));

// Problems in which two columns that follow the bound were once tried in turn
// for ever: the number is the place in the seed's sequence.
TEST(DegenerateTwinsTest, DoNotTakeTurnsForEver) {
  const struct {
    std::uint64_t seed;
    int number;
  } problems[] = {{1, 929}, {9, 862}, {9, 1343}};
  for (const auto& [seed, number] : problems) {
    DegenerateLassoGenerator generator(seed);
    for (int i = 0; i < number; ++i) generator.Next();
    ExpectSolves(generator.Next());
  }
}

}  // namespace
}  // namespace mle
