#include "mle/correction/correction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/correction/regression_data.h"

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
  if (count > 1e7) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "a grid of λ up to %g in steps of %g has %.3g values; at most 1e7", max,
        step, count + 1.0));
  }
  Eigen::VectorXd lambdas(static_cast<Eigen::Index>(count) + 1);
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    lambdas(i) = max * (static_cast<double>(i) * step / max);
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
  ArxModel model = initial_;
  Model(lambda, model);
  return model;
}

void Correction::Model(double lambda, ArxModel& model) const {
  model.R = initial_.R;
  for (std::size_t i = 0; i < fits_.size(); ++i) {
    const LassoPath& path = fits_[i].path;
    const int number = path.FindSegment(lambda);
    if (number < 0) continue;
    const LassoPath::Segment& segment = path.segments()[number];
    const double step =
        segment.lambda_begin - std::max(lambda, segment.lambda_end);
    const auto active = path.Active(segment);
    const auto start = path.Start(segment);
    const auto slope = path.Slope(segment);
    for (int a = 0; a < segment.active; ++a) {
      model.R(static_cast<Eigen::Index>(i), active(a)) +=
          inverse_scale_(active(a)) * (start(a) + step * slope(a));
    }
  }
}

absl::StatusOr<Correction> CorrectModel(const ArxModel& initial,
                                        absl::Span<const Record> windows,
                                        const CorrectionOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(
      const RegressionData data,
      RegressionData::Create(windows, initial, options.scaling));
  Correction correction;
  correction.initial_ = initial;
  MLE_ASSIGN_OR_RETURN(correction.selection_,
                       CrossValidate(data, options.scaling, options.lambdas,
                                     options.selection, options.solver));

  std::vector<RegressionRows> all;
  for (int i = 0; i < data.num_windows(); ++i) {
    all.insert(all.end(), data.window(i).begin(), data.window(i).end());
  }
  const LassoProblem problem =
      MakeLassoProblem(ComputeLaggedMoments(all), options.scaling);
  correction.inverse_scale_ =
      problem.Unscale(Eigen::VectorXd::Ones(problem.num_regressors()));
  for (int i = 0; i < problem.num_responses(); ++i) {
    MLE_ASSIGN_OR_RETURN(LassoSolution fit,
                         SolveLasso(LassoObjective(problem, i), options.lambdas,
                                    options.solver));
    correction.fits_.push_back(std::move(fit));
  }
  return correction;
}

}  // namespace mle
