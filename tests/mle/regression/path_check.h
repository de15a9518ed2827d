// An independent check of a whole lasso path.

#ifndef TESTS_MLE_REGRESSION_PATH_CHECK_H_
#define TESTS_MLE_REGRESSION_PATH_CHECK_H_

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/homotopy.h"
#include "tests/mle/regression/explicit_lasso.h"
#include "tests/mle/regression/gap_tolerance.h"

namespace mle {

// Solves `problem` down to λ = 0 and expects optimality at every knot and in
// between, by ComputeDualityGap, down to 1e-7 λ_max.
inline HomotopySummary ExpectSolves(const ExplicitLasso& problem) {
  const absl::StatusOr<HomotopySummary> summary =
      SolveHomotopy(problem.objective, {});
  EXPECT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->termination, HomotopyTermination::kReachedLambdaMin)
      << summary->BriefReport();
  const LassoPath& path = summary->path;
  std::vector<double> lambdas;
  for (const LassoPath::Segment& segment : path.segments()) {
    // The first segment may begin at infinity.
    const double begin =
        std::min(segment.lambda_begin, segment.lambda_end + 1.0);
    lambdas.insert(lambdas.end(),
                   {begin, 0.7 * begin + 0.3 * segment.lambda_end});
  }
  const double lambda_max = problem.objective.LambdaMax();
  for (const double lambda : lambdas) {
    if (lambda < 1e-7 * lambda_max) continue;
    const Eigen::VectorXd beta = path.Coefficients(lambda);
    const double gap =
        ComputeDualityGap(problem.objective, lambda, beta).Relative();
    EXPECT_LE(gap, GapTolerance(problem.objective, lambda, beta))
        << "at λ = " << lambda / lambda_max << " λ_max; "
        << summary->BriefReport();
  }
  // The end: within rounding of the least-squares minimum, where a fit may be
  // exact and the primal value nothing.
  const DualityGap end =
      ComputeDualityGap(problem.objective, 0.0, path.Coefficients(0.0));
  EXPECT_LE(end.gap, 1e-9 * end.primal + 1e-17 * end.response_square)
      << summary->BriefReport();
  return *summary;
}

}  // namespace mle

#endif  // TESTS_MLE_REGRESSION_PATH_CHECK_H_
