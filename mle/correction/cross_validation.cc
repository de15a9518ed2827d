#include "mle/correction/cross_validation.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/regression/validation_loss.h"

namespace mle {
namespace {

using Fold = std::vector<RegressionRows>;

std::vector<Fold> MakeFolds(const RegressionData& data,
                            const SelectionOptions& selection) {
  std::vector<Fold> folds;
  if (selection.rule == SelectionOptions::Rule::kLeaveChangeOut) {
    for (int i = 0; i < data.num_windows(); ++i) {
      folds.push_back(data.window(i));
    }
    return folds;
  }
  folds.resize(selection.folds);
  std::size_t next = 0;
  for (int i = 0; i < data.num_windows(); ++i) {
    for (const RegressionRows& rows : data.window(i)) {
      for (RegressionRows& block :
           SplitIntoBlocks(rows, selection.block_length)) {
        folds[next++ % folds.size()].push_back(std::move(block));
      }
    }
  }
  std::erase_if(folds, [](const Fold& fold) { return fold.empty(); });
  return folds;
}

// Index of the smallest entry, the last of several.
Eigen::Index LastArgMin(const Eigen::VectorXd& values) {
  Eigen::Index best = 0;
  for (Eigen::Index i = 1; i < values.size(); ++i) {
    if (values(i) <= values(best)) best = i;
  }
  return best;
}

}  // namespace

absl::Status SelectionOptions::Validate() const {
  if (folds < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "folds is %d; cross-validation needs at least 2", folds));
  }
  if (block_length < 1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "block_length is %d samples; it must be at least 1", block_length));
  }
  return absl::OkStatus();
}

absl::StatusOr<CrossValidationSummary> CrossValidate(
    const RegressionData& data, Scaling scaling, const Eigen::VectorXd& lambdas,
    const SelectionOptions& selection, const LassoSolverOptions& solver) {
  MLE_RETURN_IF_ERROR(selection.Validate());
  const std::vector<Fold> folds = MakeFolds(data, selection);
  if (folds.size() < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the records give %d fold; cross-validation needs at least 2: records "
        "of another set-point change, or blocks within one",
        folds.size()));
  }
  std::vector<LaggedMoments> moments;
  for (const Fold& fold : folds) moments.push_back(ComputeLaggedMoments(fold));

  CrossValidationSummary summary;
  summary.loss.setZero(lambdas.size());
  summary.penalised_loss.setZero(lambdas.size());
  std::vector<PiecewiseQuadratic> losses;
  for (std::size_t f = 0; f < folds.size(); ++f) {
    LaggedMoments others = LaggedMoments::Zero(moments[f].num_regressors(),
                                               moments[f].num_responses());
    for (std::size_t g = 0; g < folds.size(); ++g) {
      if (g != f) others += moments[g];
    }
    const LassoProblem problem = MakeLassoProblem(std::move(others), scaling);
    const ValidationRows validation(problem, moments[f]);
    for (int q = 0; q < problem.num_responses(); ++q) {
      const LassoObjective objective(problem, q);
      MLE_ASSIGN_OR_RETURN(const LassoSolution solution,
                           SolveLasso(objective, lambdas, solver));
      summary.max_relative_gap =
          std::max(summary.max_relative_gap, solution.MaxRelativeGap());
      losses.push_back(validation.Loss(solution.path, q));
      losses.back().AddTo(lambdas, summary.loss);
      PenaltyAlong(solution.path, objective.weights)
          .AddTo(lambdas, summary.penalised_loss);
    }
  }
  summary.penalised_loss += summary.loss;
  summary.lambda_star = lambdas(LastArgMin(summary.loss));
  summary.lambda_star_penalised = lambdas(LastArgMin(summary.penalised_loss));
  summary.lambda_exact = MinimizeSum(losses).lambda;
  return summary;
}

}  // namespace mle
