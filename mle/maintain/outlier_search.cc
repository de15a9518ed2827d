#include "mle/maintain/outlier_search.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/data/outliers.h"
#include "mle/maintain/select_output.h"
#include "mle/maintain/stage.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/output_reconstruction.h"

namespace mle {
namespace {

// Samples on each side that one is compared with, for bursts of up to ten.
constexpr int kWideHalfWidth = 12;
// Outliers are few: where more than this share of the samples begin a run of
// them it is the model that does not fit, or the noise.
constexpr double kMostOutliers = 0.025;

// Samples of one output that stand out of those around them, in what the model
// leaves of them too: a response that turns within the half width stands out,
// and the model has such turns.
bool StandOut(const ProcessModel& row, const Record& record) {
  const OutlierOptions options = {.half_width = kWideHalfWidth};
  const std::vector<int> found = FindOutliers(record.outputs.row(0), options);
  if (found.empty()) return false;
  const absl::StatusOr<Eigen::MatrixXd> response =
      SimulateResponse(row, record.sample_time, record.inputs);
  if (!response.ok()) return true;
  const Eigen::MatrixXd residual = record.outputs - *response;
  const std::vector<int> left = FindOutliers(residual.row(0), options);
  return std::any_of(found.begin(), found.end(), [&left](int k) {
    return std::binary_search(left.begin(), left.end(), k);
  });
}

bool NeighboursFindAny(const ProcessModel& model, const RecordData& data,
                       int output) {
  for (const ChannelHealth& channel : data.health.channels) {
    if (channel.is_output && channel.channel == output &&
        !channel.outliers.empty()) {
      return true;
    }
  }
  const ProcessModel row = SelectOutput(model, output);
  return std::any_of(data.windows.begin(), data.windows.end(),
                     [&](const SetPointWindow& window) {
                       return StandOut(row,
                                       SelectOutput(window.record, output));
                     });
}

std::vector<int> OutputsToSearch(const ProcessModel& model,
                                 const OutputErrorOptions& output_error,
                                 const RecordData& data) {
  std::vector<int> outputs;
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (output_error.robust_loss != RobustLoss::kNone ||
        NeighboursFindAny(model, data, i)) {
      outputs.push_back(i);
    }
  }
  return outputs;
}

bool AreFew(const OutlierReport& report, const std::vector<Record>& windows,
            int output) {
  double known = 0.0;
  for (const Record& window : windows) {
    known += static_cast<double>(
        window.outputs.row(output).array().isFinite().count());
  }
  return report.bursts[0] <= kMostOutliers * known;
}

Message NotOutliers(const std::string& name, int samples) {
  return {MessageCode::kUnmeasured,
          name,
          absl::StrCat(name, ": ", samples,
                       " samples are as far from the model's prediction as "
                       "outliers, which are not so many: the model does not "
                       "fit there. These samples are used."),
          {}};
}

// Reports the outliers that the model found in an output.
void ReportOutliers(const std::string& name, const OutlierReport& report,
                    RecordData& data) {
  if (report.marked[0] > 0) {
    data.notes.push_back(
        {MessageCode::kSamplesMarked,
         name,
         absl::StrCat(
             name, ": ", report.marked[0],
             " samples of the windows are outliers under the model, at most ",
             report.longest[0], " in a row, and are marked as bad."),
         {"mark_outliers"}});
  }
  if (report.left[0] > 0) {
    data.warnings.push_back(
        {MessageCode::kUnmeasured,
         name,
         absl::StrCat(
             name, ": ", report.left[0],
             " samples are as far from the model's prediction as outliers, "
             "but more than ",
             OutlierMarkOptions().longest_burst,
             " in a row: an unmeasured disturbance. These samples are used."),
         {}});
  }
}

}  // namespace

absl::Status SearchOutliers(const ProcessModel& model,
                            const RecordOptions& options,
                            const OutputErrorOptions& output_error,
                            const ProgressCallback& progress,
                            RecordData& data) {
  if (!options.mark.outliers) return absl::OkStatus();
  const std::vector<int> outputs = OutputsToSearch(model, output_error, data);
  if (outputs.empty()) return absl::OkStatus();
  const auto count = static_cast<int>(outputs.size());
  Stage stage(progress, "looking for outliers", count);
  MLE_RETURN_IF_ERROR(stage.status());
  OutputErrorOptions alone = output_error;
  alone.threads = 1;
  alone.outputs = {};
  const std::vector<Record> windows = data.Records();
  std::vector<std::vector<Record>> searched(count);
  std::vector<absl::StatusOr<OutlierReport>> reports(count);
  ParallelFor(count, output_error.threads, [&](int n) {
    if (stage.cancelled()) return;
    for (const Record& window : windows) {
      searched[n].push_back(SelectOutput(window, outputs[n]));
    }
    reports[n] = MarkOutliers(SelectOutput(model, outputs[n]), alone,
                              OutlierMarkOptions(), searched[n]);
    stage.Done();
  });
  MLE_RETURN_IF_ERROR(stage.status());
  data.outliers_by_model.assign(model.num_outputs(), 0);
  for (int n = 0; n < count; ++n) {
    // An output that cannot be fitted is reported where the model is fitted.
    if (!reports[n].ok()) continue;
    const int i = outputs[n];
    const std::string& name = model.outputs()[i].name;
    if (!AreFew(*reports[n], windows, i)) {
      data.warnings.push_back(NotOutliers(name, reports[n]->marked[0]));
      continue;
    }
    for (std::size_t w = 0; w < data.windows.size(); ++w) {
      Record& window = data.windows[w].record;
      window.outputs.row(i) =
          searched[n][w].outputs.row(0).tail(window.samples());
    }
    data.outliers_by_model[i] = reports[n]->marked[0];
    ReportOutliers(name, *reports[n], data);
  }
  return absl::OkStatus();
}

}  // namespace mle
