// The path on thousands of problems that are as degenerate as can be.

#include "tests/mle/regression/degenerate_lasso.h"

#include <cstdint>

#include "gtest/gtest.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/homotopy.h"
#include "tests/mle/regression/lagged_lasso.h"
#include "tests/mle/regression/path_check.h"

namespace mle {
namespace {

// Down to `smallest_part` of λ_max the path is right to its rounding, and what
// is certified is so. Where a tie or rounding stops it, that is further down.
void ExpectSolvedDownTo(double smallest_part, const ExplicitLasso& problem,
                        int number) {
  const double lambda_max = problem.objective.LambdaMax();
  if (lambda_max == 0.0) return;
  HomotopyOptions options;
  options.certify_at =
      LambdaGrid(lambda_max, smallest_part, 20, /*with_zero=*/true);
  const auto summary = SolveHomotopy(problem.objective, options);
  ASSERT_TRUE(summary.ok()) << summary.status();
  if (summary->termination != HomotopyTermination::kReachedLambdaMin) {
    EXPECT_LE(summary->path.lambda_end(), 0.1 * smallest_part * lambda_max)
        << "problem " << number << ": " << summary->BriefReport();
  }
  for (Eigen::Index i = 1; i < options.certify_at.size(); ++i) {
    const double lambda = options.certify_at(i);
    const Eigen::VectorXd beta = summary->path.Coefficients(lambda);
    const double tolerance = GapTolerance(problem.objective, lambda, beta);
    EXPECT_LE(ComputeDualityGap(problem.objective, lambda, beta).Relative(),
              tolerance)
        << "problem " << number << ", λ = " << lambda / lambda_max << " λ_max; "
        << summary->BriefReport();
    EXPECT_LE(summary->relative_gap(i), tolerance) << "problem " << number;
  }
}

class DegenerateLassoTest : public ::testing::TestWithParam<int> {};

TEST_P(DegenerateLassoTest, SmallProblemsFullOfTies) {
  DegenerateLassoGenerator generator(GetParam());
  for (int number = 0; number < 400; ++number) {
    ExpectSolvedDownTo(1e-6, generator.Next(), number);
  }
}

// Where the active columns are nearly dependent, β must be right to its last
// digit for a variable to leave where its c_j meets the bound.
TEST_P(DegenerateLassoTest, LagsOfSlowAndHeldSignals) {
  LaggedLassoGenerator generator(GetParam());
  for (int number = 0; number < 30; ++number) {
    ExpectSolvedDownTo(1e-7, generator.Next(), number);
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
