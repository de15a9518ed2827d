#include "mle/regression/lasso_solver.h"

#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/regression/coordinate_descent.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/elastic_net.h"
#include "mle/regression/homotopy.h"
#include "mle/regression/lasso_function_path.h"

namespace mle {
namespace {

// Solves lambdas(first) … lambdas(0) by coordinate descent, going down from the
// end of the path.
absl::Status Descend(const LassoObjective& objective,
                     const CoordinateDescentOptions& options,
                     Eigen::Index first, LassoSolution& solution) {
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(objective.size());
  double lambda_before = objective.LambdaMax();
  if (!solution.path.segments().empty()) {
    lambda_before = solution.path.lambda_end();
    beta = solution.path.Coefficients(lambda_before);
  }
  int not_converged = 0;
  for (Eigen::Index i = first; i >= 0; --i) {
    const double lambda = solution.lambdas(i);
    CoordinateDescentSummary summary;
    if (lambda > 0.0) {
      MLE_ASSIGN_OR_RETURN(
          summary, SolveCoordinateDescent(objective, lambda, beta, options));
      not_converged += summary.converged ? 0 : 1;
    } else {
      // Sweeps hardly get there; a rank-revealing solve does.
      summary.beta = MinimumNormLeastSquares(objective);
      summary.gap = ComputeDualityGap(objective, 0.0, summary.beta);
    }
    solution.relative_gap(i) = summary.gap.Relative();
    // Unpenalised coefficients do not vanish at λ_max: the path begins above
    // every λ, with those of the first.
    if (solution.path.segments().empty() &&
        (objective.weights.array() == 0.0).any()) {
      lambda_before = std::numeric_limits<double>::max();
      beta = summary.beta;
    }
    solution.path.AppendJoin(lambda_before, beta, lambda, summary.beta);
    if (lambda < lambda_before) lambda_before = lambda;
    beta = std::move(summary.beta);
  }
  absl::StrAppendFormat(&solution.report,
                        "coordinate descent: %d values of λ, %d not converged",
                        first + 1, not_converged);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LassoSolution> SolveLasso(const LassoObjective& objective,
                                         const Eigen::VectorXd& lambdas,
                                         const LassoSolverOptions& options) {
  if (lambdas.size() == 0) {
    return absl::InvalidArgumentError("lasso: the grid of λ is empty");
  }
  MLE_RETURN_IF_ERROR(objective.Validate());
  if (options.solver == LassoSolver::kElasticNet) {
    ElasticNetOptions elastic_net;
    elastic_net.ratio = options.elastic_net_ratio;
    return SolveElasticNet(objective, lambdas, elastic_net);
  }
  LassoSolution solution;
  solution.lambdas = lambdas;
  HomotopyOptions homotopy;
  homotopy.lambda_min = lambdas(0);
  homotopy.certify_at = lambdas;
  MLE_RETURN_IF_ERROR(homotopy.Validate());
  if (options.solver == LassoSolver::kFunction) {
    if (!options.function) {
      return absl::InvalidArgumentError(
          "lasso: the solver is a function, and none is given");
    }
    MLE_RETURN_IF_ERROR(SolveByFunction(objective, options.function, solution));
    return solution;
  }
  if (options.solver == LassoSolver::kCoordinateDescent) {
    solution.path = LassoPath(objective.size());
    solution.relative_gap.setZero(lambdas.size());
    MLE_RETURN_IF_ERROR(Descend(objective, options.coordinate_descent,
                                lambdas.size() - 1, solution));
    return solution;
  }

  MLE_ASSIGN_OR_RETURN(HomotopySummary summary,
                       SolveHomotopy(objective, homotopy));
  solution.report = summary.BriefReport();
  solution.path = std::move(summary.path);
  solution.relative_gap = std::move(summary.relative_gap);
  Eigen::Index unsolved = 0;
  while (unsolved < lambdas.size() &&
         !std::isfinite(solution.relative_gap(unsolved))) {
    ++unsolved;
  }
  if (unsolved > 0) {
    absl::StrAppend(&solution.report, "; from there on ");
    MLE_RETURN_IF_ERROR(
        Descend(objective, options.coordinate_descent, unsolved - 1, solution));
  }
  return solution;
}

}  // namespace mle
