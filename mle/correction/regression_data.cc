#include "mle/correction/regression_data.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"

namespace mle {
namespace {

absl::Status CheckWindow(const Record& window, const ArxModel& model,
                         int number) {
  MLE_RETURN_IF_ERROR(window.Validate());
  if (window.num_outputs() != model.num_outputs ||
      window.num_inputs() != model.num_inputs) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "window %d has %d outputs and %d inputs, the model %d and %d", number,
        window.num_outputs(), window.num_inputs(), model.num_outputs,
        model.num_inputs));
  }
  if (!(std::abs(window.sample_time - model.sample_time) <=
        1e-9 * model.sample_time)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("window %d is sampled every %g, the model every %g",
                        number, window.sample_time, model.sample_time));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<RegressionData> RegressionData::Create(
    absl::Span<const Record> windows, const ArxModel& model, Scaling scaling,
    bool window_intercepts) {
  MLE_RETURN_IF_ERROR(model.Validate());
  if (windows.empty()) {
    return absl::InvalidArgumentError(
        "there is no window to learn from; at least one is needed");
  }
  for (std::size_t i = 0; i < windows.size(); ++i) {
    MLE_RETURN_IF_ERROR(
        CheckWindow(windows[i], model, static_cast<int>(i) + 1));
  }
  Eigen::VectorXd offset;
  if (scaling == Scaling::kStandardise) {
    offset = ChannelMeans({windows.begin(), windows.end()});
  }
  RegressionData data;
  data.order_ = model.order;
  data.model_R_ = model.R;
  if (window_intercepts) data.num_groups_ = static_cast<int>(windows.size());
  for (std::size_t i = 0; i < windows.size(); ++i) {
    if (scaling == Scaling::kStandardise && window_intercepts) {
      offset = ChannelMeans({windows[i]});
    }
    const int group = window_intercepts ? static_cast<int>(i) : 0;
    const LaggedSeries& series =
        data.series_.emplace_back(windows[i], model.order, offset);
    std::vector<RegressionRows>& rows = data.rows_.emplace_back();
    for (const RowRange range : series.UsableRows()) {
      Eigen::MatrixXd residual = series.Outputs(range);
      residual.noalias() -= model.R * series.Regressors(range);
      rows.push_back({&series, range, std::move(residual), group});
    }
    if (rows.empty()) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "window %d has %d samples and leaves no row: a row needs %d "
          "consecutive good samples (order %d and the sample predicted)",
          i + 1, windows[i].samples(), model.order + 1, model.order));
    }
  }
  return data;
}

}  // namespace mle
