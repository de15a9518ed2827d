#include "mle/correction/correction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "glog/logging.h"
#include "mle/base/status.h"
#include "mle/correction/cross_validation.h"
#include "mle/regression/row_certificate.h"

namespace mle {

absl::Status CorrectionOptions::Validate() const {
  if (lambdas.size() == 0) {
    return absl::InvalidArgumentError("the grid of λ is empty");
  }
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    if (!(lambdas(i) >= 0.0) || !std::isfinite(lambdas(i)) ||
        (i > 0 && lambdas(i) <= lambdas(i - 1))) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "value %d of the grid of λ is %g; they must be ≥ 0 and ascend", i + 1,
          lambdas(i)));
    }
  }
  if (window_intercepts && scaling == Scaling::kRaw) {
    return absl::InvalidArgumentError(
        "an intercept for each window needs centred data, but the scaling is "
        "raw");
  }
  return selection.Validate();
}

absl::StatusOr<Eigen::VectorXd> MakeLambdaGrid(double max, double step) {
  if (!(max > 0.0) || !std::isfinite(max) || !(step > 0.0) || step > max) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "a grid of λ up to %g in steps of %g: both must be positive and the "
        "step not above the maximum",
        max, step));
  }
  const double count = std::floor(max / step * (1.0 + 1e-12));
  if (!(count <= 1e7)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "a grid of λ up to %g in steps of %g has too many values; at most 1e7",
        max, step));
  }
  const bool whole = std::abs(count * step - max) <= 1e-12 * max;
  Eigen::VectorXd lambdas(static_cast<Eigen::Index>(count) + 1);
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    // The nearest number to i·step where step divides max, which i·step is not.
    lambdas(i) = whole ? static_cast<double>(i) * max / count
                       : static_cast<double>(i) * step;
  }
  return lambdas;
}

double Correction::MaxRelativeGap() const {
  double worst = selection_.max_relative_gap;
  for (const LassoSolution& fit : fits_) {
    worst = std::max(worst, fit.MaxRelativeGap());
  }
  return worst;
}

ArxModel Correction::Model(double lambda) const {
  return Model(Eigen::VectorXd::Constant(initial_.num_outputs, lambda).eval());
}

ArxModel Correction::Model(const Eigen::VectorXd& lambdas) const {
  ArxModel model = initial_;
  Model(lambdas, model);
  return model;
}

void Correction::Model(const Eigen::VectorXd& lambdas, ArxModel& model) const {
  CHECK_EQ(lambdas.size(), initial_.num_outputs);
  model.R = initial_.R;
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    // Constant regressors are never active.
    fits_[i].path.VisitCoefficients(lambdas(i), [&](int j, double beta) {
      model.R(i, j) += beta / problem_.scale(j);
    });
  }
}

absl::Status Correction::Select(const SelectionOptions& options) {
  MLE_ASSIGN_OR_RETURN(
      selection_, SelectLambda(*data_, scaling_, penalty_weights_, moments_,
                               problem_, fits_, options, solver_));
  selection_options_ = options;
  return absl::OkStatus();
}

absl::StatusOr<Correction> CorrectModel(const ArxModel& initial,
                                        absl::Span<const Record> windows,
                                        const CorrectionOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  Correction correction;
  correction.initial_ = initial;
  correction.scaling_ = options.scaling;
  correction.solver_ = options.solver;
  correction.penalty_weights_ = options.penalty_weights;
  if (options.penalty_weights.size() > 0 &&
      (options.penalty_weights.rows() != initial.num_outputs ||
       options.penalty_weights.cols() != initial.num_regressors())) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the penalty weights are %d × %d; they must be %d × %d, a row for each "
        "output and a column for each regressor, or empty",
        options.penalty_weights.rows(), options.penalty_weights.cols(),
        initial.num_outputs, initial.num_regressors()));
  }
  MLE_ASSIGN_OR_RETURN(RegressionData data,
                       RegressionData::Create(windows, initial, options.scaling,
                                              options.window_intercepts));
  correction.data_ = std::make_shared<RegressionData>(std::move(data));
  std::vector<RegressionRows> all;
  for (int i = 0; i < correction.data_->num_windows(); ++i) {
    const std::vector<RegressionRows>& rows = correction.data_->window(i);
    all.insert(all.end(), rows.begin(), rows.end());
  }
  correction.moments_ =
      ComputeLaggedMoments(all, correction.data_->num_groups());
  correction.problem_ = MakeLassoProblem(correction.moments_, options.scaling);
  for (int i = 0; i < correction.problem_.num_responses(); ++i) {
    const LassoObjective objective(correction.problem_, i,
                                   PenaltyWeights(options.penalty_weights, i));
    MLE_ASSIGN_OR_RETURN(
        LassoSolution fit,
        SolveLasso(objective, options.lambdas, options.solver));
    if (options.solver.solver != LassoSolver::kElasticNet) {
      CertifyByRows(all, correction.problem_, i, objective, fit);
    }
    correction.fits_.push_back(std::move(fit));
  }
  MLE_RETURN_IF_ERROR(correction.Select(options.selection));
  return correction;
}

}  // namespace mle
