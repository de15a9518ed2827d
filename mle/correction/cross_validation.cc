#include "mle/correction/cross_validation.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "glog/logging.h"
#include "mle/base/status.h"
#include "mle/correction/prediction_residuals.h"
#include "mle/regression/validation_loss.h"

namespace mle {
namespace {

// One fold: fits to the others' moments, scored on its own.
class FoldFit {
 public:
  FoldFit(std::vector<LaggedMoments>& moments, std::size_t fold,
          const CrossValidationOptions& options)
      : options_(options), own_(moments[fold]) {
    LaggedMoments others = LaggedMoments::Zero(
        own_.num_regressors(), own_.num_responses(), own_.num_groups());
    for (std::size_t g = 0; g < moments.size(); ++g) {
      if (g != fold) others += moments[g];
    }
    problem_ = MakeLassoProblem(std::move(others), options.scaling);
  }

  absl::Status Solve() {
    for (int q = 0; q < problem_.num_responses(); ++q) {
      MLE_ASSIGN_OR_RETURN(LassoSolution solution,
                           SolveLasso(LassoObjective(problem_, q, Weights(q)),
                                      options_.grid, options_.solver));
      solutions_.push_back(std::move(solution));
    }
    return absl::OkStatus();
  }

  const std::vector<LassoSolution>& solutions() const { return solutions_; }

  std::vector<PiecewiseQuadratic> OneStepLosses() const {
    const ValidationRows validation(problem_, own_);
    std::vector<PiecewiseQuadratic> losses;
    for (std::size_t q = 0; q < solutions_.size(); ++q) {
      losses.push_back(
          validation.Loss(solutions_[q].path, static_cast<int>(q)));
    }
    return losses;
  }

  void AddPenalty(double weight, Eigen::VectorXd& penalty) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(options_.lambdas.size());
    for (std::size_t q = 0; q < solutions_.size(); ++q) {
      Eigen::VectorXd weights = Weights(static_cast<int>(q));
      if (weights.size() == 0) weights.setOnes(problem_.num_regressors());
      PenaltyAlong(solutions_[q].path, weights).AddTo(options_.lambdas, sum);
    }
    penalty += weight * sum;
  }

  // ΔR(λ).
  Eigen::MatrixXd Change(double lambda) const {
    Eigen::MatrixXd change(problem_.num_responses(), problem_.num_regressors());
    for (std::size_t q = 0; q < solutions_.size(); ++q) {
      change.row(static_cast<Eigen::Index>(q)) =
          problem_.Unscale(solutions_[q].path.Coefficients(lambda)).transpose();
    }
    return change;
  }

 private:
  Eigen::VectorXd Weights(int output) const {
    return PenaltyWeights(options_.penalty_weights, output);
  }

  const CrossValidationOptions& options_;
  const LaggedMoments& own_;
  LassoProblem problem_;
  std::vector<LassoSolution> solutions_;
};

}  // namespace

Eigen::VectorXd PenaltyWeights(const Eigen::MatrixXd& all, int output) {
  return all.size() > 0 ? Eigen::VectorXd(all.row(output)) : Eigen::VectorXd();
}

void FoldLosses::Append(FoldLosses more) {
  if (values.empty()) {
    *this = std::move(more);
    return;
  }
  CHECK_EQ(values.size(), more.values.size());
  const auto stack = [](const auto& above, const auto& below) {
    Eigen::MatrixXd both(above.rows() + below.rows(), above.cols());
    both << above, below;
    return both;
  };
  for (std::size_t q = 0; q < values.size(); ++q) {
    values[q] = stack(values[q], more.values[q]);
  }
  weight = stack(weight, more.weight);
  exact.insert(exact.end(), std::make_move_iterator(more.exact.begin()),
               std::make_move_iterator(more.exact.end()));
  penalty += more.penalty;
  max_relative_gap = std::max(max_relative_gap, more.max_relative_gap);
}

absl::StatusOr<FoldLosses> CrossValidate(
    const RegressionData& data, const std::vector<Fold>& folds,
    const CrossValidationOptions& options) {
  CHECK_GE(folds.size(), 2U);
  const Eigen::VectorXd& lambdas = options.lambdas;
  std::vector<LaggedMoments> moments;
  for (const Fold& fold : folds) {
    moments.push_back(ComputeLaggedMoments(fold, data.num_groups()));
  }
  const auto count = static_cast<Eigen::Index>(folds.size());
  FoldLosses losses;
  losses.weight.resize(count);
  for (Eigen::Index f = 0; f < count; ++f) {
    losses.weight(f) = static_cast<double>(moments[f].rows);
  }
  losses.weight /= losses.weight.mean();
  losses.values.assign(moments.front().num_responses(),
                       Eigen::MatrixXd::Zero(count, lambdas.size()));
  losses.penalty.setZero(lambdas.size());

  for (Eigen::Index f = 0; f < count; ++f) {
    FoldFit fit(moments, static_cast<std::size_t>(f), options);
    MLE_RETURN_IF_ERROR(fit.Solve());
    for (const LassoSolution& solution : fit.solutions()) {
      losses.max_relative_gap =
          std::max(losses.max_relative_gap, solution.MaxRelativeGap());
    }
    if (options.horizon == 1) {
      losses.exact.push_back(fit.OneStepLosses());
      fit.AddPenalty(losses.weight(f), losses.penalty);
      for (std::size_t q = 0; q < losses.values.size(); ++q) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(lambdas.size());
        losses.exact.back()[q].AddTo(lambdas, row);
        losses.values[q].row(f) = row.transpose();
        losses.exact.back()[q].Scale(losses.weight(f));
      }
    } else {
      const AheadLosses ahead(data, folds[f], options.horizon);
      // Two λ at a time share the reading of the rows.
      for (Eigen::Index i = 0; i < lambdas.size(); i += 2) {
        std::vector<Eigen::MatrixXd> changes;
        for (const double lambda : lambdas.segment(
                 i, std::min<Eigen::Index>(2, lambdas.size() - i))) {
          changes.push_back(fit.Change(lambda));
        }
        const Eigen::MatrixXd loss = ahead.Of(changes);
        for (std::size_t q = 0; q < losses.values.size(); ++q) {
          losses.values[q].row(f).segment(i, loss.cols()) =
              loss.row(static_cast<Eigen::Index>(q));
        }
      }
    }
  }
  return losses;
}

}  // namespace mle
