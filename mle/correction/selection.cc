#include "mle/correction/selection.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/correction/cross_validation.h"
#include "mle/correction/folds.h"
#include "mle/correction/response_risk.h"
#include "mle/regression/validation_loss.h"

namespace mle {
namespace {

using Rule = SelectionOptions::Rule;

constexpr int kBlockOrders = 2;
constexpr int kOrdersOverHorizon = 5;
// Least ratios of neighbouring λ at which a loss is found by simulation, and Ê.
constexpr double kThinning = 1.25;
constexpr double kResponseThinning = 1.4;
// Length of the step responses whose error is estimated.
constexpr int kOrdersOfResponse = 3;

// Index of the smallest entry, the last of several: the larger λ.
Eigen::Index LastArgMin(const Eigen::VectorXd& values) {
  Eigen::Index best = 0;
  for (Eigen::Index i = 1; i < values.size(); ++i) {
    if (values(i) <= values(best)) best = i;
  }
  return best;
}

// Every λ whose ratio to the last one taken is at least `ratio`; the first and
// the last are among them.
Eigen::VectorXd Thin(const Eigen::VectorXd& lambdas, double ratio) {
  std::vector<double> taken;
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    if (taken.empty() || i + 1 == lambdas.size() ||
        lambdas(i) >= ratio * taken.back()) {
      taken.push_back(lambdas(i));
    }
  }
  return Eigen::Map<const Eigen::VectorXd>(taken.data(), taken.size());
}

// The largest λ whose weighted mean loss is within a standard error of the
// smallest.
double OneStandardError(const Eigen::MatrixXd& values,
                        const Eigen::VectorXd& weight,
                        const Eigen::VectorXd& lambdas) {
  const double count = static_cast<double>(values.rows());
  const Eigen::VectorXd mean = values.transpose() * weight / count;
  const Eigen::Index best = LastArgMin(mean);
  const double variance =
      (values.col(best).array() - mean(best)).square().sum() / (count - 1.0);
  const double limit = mean(best) + std::sqrt(variance / count);
  for (Eigen::Index i = lambdas.size() - 1; i > best; --i) {
    if (mean(i) <= limit) return lambdas(i);
  }
  return lambdas(best);
}

SelectionSummary Choose(const FoldLosses& losses,
                        const Eigen::VectorXd& lambdas,
                        const SelectionOptions& options) {
  const auto outputs = losses.values.size();
  SelectionSummary summary;
  summary.lambdas = lambdas;
  summary.max_relative_gap = losses.max_relative_gap;
  Eigen::MatrixXd sum =
      Eigen::MatrixXd::Zero(losses.weight.size(), lambdas.size());
  for (const Eigen::MatrixXd& values : losses.values) sum += values;
  summary.loss = sum.transpose() * losses.weight;
  if (!losses.exact.empty()) {
    summary.penalised_loss = summary.loss + losses.penalty;
    summary.lambda_star_penalised = lambdas(LastArgMin(summary.penalised_loss));
  }
  // Chooses λ for the outputs first … last together.
  const auto choose = [&](std::size_t first, std::size_t last) {
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(sum.rows(), sum.cols());
    std::vector<PiecewiseQuadratic> exact;
    for (std::size_t q = first; q <= last; ++q) {
      values += losses.values[q];
      for (const auto& fold : losses.exact) exact.push_back(fold[q]);
    }
    if (options.one_standard_error) {
      return OneStandardError(values, losses.weight, lambdas);
    }
    if (!exact.empty() && !options.on_grid) return MinimizeSum(exact).lambda;
    return lambdas(LastArgMin(values.transpose() * losses.weight));
  };
  summary.lambda_star.setConstant(static_cast<Eigen::Index>(outputs),
                                  choose(0, outputs - 1));
  if (options.per_output) {
    for (std::size_t q = 0; q < outputs; ++q) {
      summary.lambda_star(static_cast<Eigen::Index>(q)) = choose(q, q);
    }
  }
  return summary;
}

// N log(RSS/N) + c df (AIC: c = 2, BIC: c = log N), or N log of GCV's
// RSS/N / (1 − df/N)²; the outputs' add up.
SelectionSummary ChooseByCriterion(const LaggedMoments& moments,
                                   const LassoProblem& problem,
                                   absl::Span<const LassoSolution> fits,
                                   const SelectionOptions& options) {
  const Eigen::VectorXd& lambdas = fits.front().lambdas;
  const double rows = static_cast<double>(problem.rows);
  const double rounding = std::numeric_limits<double>::epsilon();
  const ValidationRows in_sample(problem, moments);
  SelectionSummary summary;
  summary.lambdas = lambdas;
  summary.loss.setZero(lambdas.size());
  summary.lambda_star.resize(static_cast<Eigen::Index>(fits.size()));
  for (std::size_t q = 0; q < fits.size(); ++q) {
    const LassoPath& path = fits[q].path;
    const PiecewiseQuadratic loss = in_sample.Loss(path, static_cast<int>(q));
    const double floor =
        rounding * problem.response_square(static_cast<Eigen::Index>(q)) +
        std::numeric_limits<double>::min();
    Eigen::VectorXd criterion(lambdas.size());
    for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
      const double variance = std::max(2.0 * loss(lambdas(i)), floor);
      const int segment = path.FindSegment(lambdas(i));
      const double df = segment < 0 ? 0.0 : path.segments()[segment].active;
      const double penalty = options.rule == Rule::kAic   ? 2.0 * df
                             : options.rule == Rule::kBic ? std::log(rows) * df
                             : df < rows
                                 ? -2.0 * rows * std::log1p(-df / rows)
                                 : std::numeric_limits<double>::infinity();
      criterion(i) = rows * std::log(variance) + penalty;
    }
    summary.lambda_star(static_cast<Eigen::Index>(q)) =
        lambdas(LastArgMin(criterion));
    summary.loss += criterion;
  }
  if (!options.per_output) {
    summary.lambda_star.setConstant(lambdas(LastArgMin(summary.loss)));
  }
  return summary;
}

// The ways to deal the rows into folds whose losses are added.
absl::StatusOr<std::vector<std::vector<Fold>>> Partitions(
    const RegressionData& data, const SelectionOptions& options) {
  std::vector<std::vector<Fold>> partitions;
  if (options.rule == Rule::kLeaveChangeOut) {
    partitions.push_back(FoldsByWindow(data));
    if (partitions.front().size() >= 2) return partitions;
    return absl::InvalidArgumentError(
        "there is 1 set-point change; leaving a change out needs at least 2. "
        "Choose λ by blocks instead");
  }
  const int length = options.BlockLength(data.order());
  // More phases than samples of a block would cut the same again.
  const int phases = std::min(options.phases, length);
  for (int phase = 0; phase < phases; ++phase) {
    std::vector<Fold> folds =
        FoldsByBlock(data, options.folds, length,
                     static_cast<int>(std::int64_t{phase} * length / phases));
    if (folds.size() < 2) {
      return absl::InvalidArgumentError(
          absl::StrFormat("the records make a single block of %d rows; "
                          "cross-validation needs at least 2 blocks",
                          length));
    }
    partitions.push_back(std::move(folds));
  }
  return partitions;
}

// λ* from the losses on the folds of all partitions, on the grid of
// `cross_validation`.
absl::StatusOr<SelectionSummary> ChooseByFolds(
    const RegressionData& data,
    const std::vector<std::vector<Fold>>& partitions,
    const SelectionOptions& options, CrossValidationOptions cross_validation) {
  cross_validation.lambdas = cross_validation.horizon == 1
                                 ? cross_validation.grid
                                 : Thin(cross_validation.grid, kThinning);
  FoldLosses losses;
  for (const std::vector<Fold>& folds : partitions) {
    MLE_ASSIGN_OR_RETURN(FoldLosses more,
                         CrossValidate(data, folds, cross_validation));
    losses.Append(std::move(more));
  }
  return Choose(losses, cross_validation.lambdas, options);
}

// The λ of least loss along the grid of `cross_validation`.
absl::StatusOr<SelectionSummary> CrossValidatePath(
    const RegressionData& data, const SelectionOptions& options,
    CrossValidationOptions cross_validation) {
  MLE_ASSIGN_OR_RETURN(const std::vector<std::vector<Fold>> partitions,
                       Partitions(data, options));
  const Eigen::VectorXd grid = cross_validation.grid;
  if (cross_validation.horizon != 1 && grid.size() > 2 && grid(0) == 0.0) {
    // A third of a path's work lies below the smallest λ > 0.
    cross_validation.grid = grid.tail(grid.size() - 1);
    MLE_ASSIGN_OR_RETURN(
        SelectionSummary summary,
        ChooseByFolds(data, partitions, options, cross_validation));
    if (summary.lambda_star.minCoeff() > grid(1)) return summary;
  }
  cross_validation.grid = grid;
  return ChooseByFolds(data, partitions, options, cross_validation);
}

// The smallest λ that corrects nothing that is penalised.
double NoCorrection(const LassoProblem& problem,
                    const Eigen::MatrixXd& penalty_weights) {
  double lambda = 0.0;
  for (int q = 0; q < problem.num_responses(); ++q) {
    const LassoObjective objective(problem, q,
                                   PenaltyWeights(penalty_weights, q));
    lambda = std::max(lambda, objective.LambdaMax());
  }
  return lambda;
}

// Replaces λ* of least loss where the step responses speak against it.
void CheckResponses(const RegressionData& data,
                    const Eigen::MatrixXd& penalty_weights,
                    const LassoProblem& problem,
                    absl::Span<const LassoSolution> fits,
                    const SelectionOptions& options,
                    SelectionSummary& summary) {
  ArxModel initial;
  initial.R = data.model_R();
  initial.order = data.order();
  initial.num_outputs = problem.num_responses();
  initial.num_inputs =
      problem.num_regressors() / data.order() - initial.num_outputs;
  const std::optional<ResponseRisk> risk = ResponseRisk::Create(
      initial, problem, penalty_weights, kOrdersOfResponse * data.order() + 1);
  if (!risk.has_value()) return;
  summary.response_lambdas = Thin(fits.front().lambdas, kResponseThinning);
  summary.response_risk.resize(summary.response_lambdas.size());
  for (Eigen::Index i = 0; i < summary.response_risk.size(); ++i) {
    summary.response_risk(i) = (*risk)(fits, summary.response_lambdas(i));
  }
  summary.response_deviation = risk->deviation();
  const Eigen::Index best = LastArgMin(summary.response_risk);
  const double limit = summary.response_risk(best) +
                       options.response_deviations * risk->deviation();
  const double proposed = summary.lambda_star(0);
  double none = NoCorrection(problem, penalty_weights);
  if (proposed >= none) return;
  if (options.on_grid) {
    const Eigen::VectorXd& grid = fits.front().lambdas;
    none = *std::lower_bound(grid.begin(), grid.end() - 1, none);
  }
  double chosen = summary.response_lambdas(best);
  for (const double lambda : {none, proposed}) {
    if ((*risk)(fits, lambda) <= limit) {
      chosen = lambda;
      break;
    }
  }
  summary.lambda_star.setConstant(chosen);
}

}  // namespace

absl::Status SelectionOptions::Validate() const {
  if (folds < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "folds is %d; cross-validation needs at least 2", folds));
  }
  if (block_length < 0) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "block_length is %d samples; it must be at least 1, or 0 for the "
        "default",
        block_length));
  }
  if (phases < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("phases is %d; it must be at least 1", phases));
  }
  if (!(response_deviations >= 0.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("response_deviations is %g; it must be at least 0",
                        response_deviations));
  }
  if (horizon < -1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "horizon is %d samples; it must be at least 1, 0 for the whole window "
        "or -1 for the default",
        horizon));
  }
  return absl::OkStatus();
}

int SelectionOptions::BlockLength(int order) const {
  return block_length > 0 ? block_length : kBlockOrders * order;
}

int SelectionOptions::Horizon(int order) const {
  return horizon >= 0 ? horizon : std::max(order / kOrdersOverHorizon, 1);
}

absl::StatusOr<SelectionSummary> SelectLambda(
    const RegressionData& data, Scaling scaling,
    const Eigen::MatrixXd& penalty_weights, const LaggedMoments& moments,
    const LassoProblem& problem, absl::Span<const LassoSolution> fits,
    const SelectionOptions& options, const LassoSolverOptions& solver) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (options.rule != Rule::kBlocks && options.rule != Rule::kLeaveChangeOut) {
    return ChooseByCriterion(moments, problem, fits, options);
  }
  CrossValidationOptions cross_validation;
  cross_validation.scaling = scaling;
  cross_validation.penalty_weights = penalty_weights;
  cross_validation.horizon = options.Horizon(data.order());
  cross_validation.grid = fits.front().lambdas;
  cross_validation.solver = solver;
  MLE_ASSIGN_OR_RETURN(SelectionSummary summary,
                       CrossValidatePath(data, options, cross_validation));
  if (options.rule == Rule::kBlocks && options.response_deviations > 0.0 &&
      !options.per_output) {
    CheckResponses(data, penalty_weights, problem, fits, options, summary);
  }
  return summary;
}

}  // namespace mle
