#include "mle/maintain/used_windows.h"

#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/nearest_names.h"
#include "mle/data/record_columns.h"
#include "mle/data/set_point_windows.h"
#include "mle/maintain/informative_windows.h"
#include "mle/maintain/leave_out.h"
#include "mle/maintain/whole_windows.h"

namespace mle {
namespace {

// Leaves out, or cuts, windows in which inputs are missing.
void MakeInputsWhole(const ProcessModel& model, RecordData& data) {
  std::vector<SetPointWindow> whole;
  for (SetPointWindow& window : data.windows) {
    const std::string name =
        absl::StrCat("The window from ",
                     data.Times(model).Span(BeginOf(window), EndOf(window)));
    const SampleRange range = WholeInputs(window.record);
    if (range.samples() == window.record.samples()) {
      whole.push_back(std::move(window));
      continue;
    }
    if (range.samples() > 0) Cut(range, window);
    if (range.samples() < 2 || window.changes.empty()) {
      data.warnings.push_back(
          {MessageCode::kWindowDropped,
           name,
           absl::StrCat(
               name,
               " is left out: inputs are missing around its set-point change."),
           {"max_gap"}});
      continue;
    }
    data.warnings.push_back(
        {MessageCode::kWindowCut,
         name,
         absl::StrCat(name,
                      " is cut to its longest part without missing inputs."),
         {"max_gap"}});
    whole.push_back(std::move(window));
  }
  data.windows = std::move(whole);
}

bool AnyMoves(const std::vector<Record>& records,
              Eigen::MatrixXd Record::*signals) {
  for (const Record& record : records) {
    const Eigen::MatrixXd& values = record.*signals;
    for (Eigen::Index k = 1; k < values.cols(); ++k) {
      const auto moves = values.col(k) - values.col(k - 1);
      if ((moves.array().abs() > 0.0).any()) return true;
    }
  }
  return false;
}

// Columns that are ignored and look like set points.
std::vector<std::string> LikelySetPoints(const RecordData& data) {
  std::vector<std::string> likely;
  for (const FileReport& file : data.report.files) {
    for (const std::string& column : file.ignored_columns) {
      if (IsSetPointTag(column)) likely.push_back(column);
    }
  }
  return likely;
}

absl::Status NoWindows(const RecordData& data) {
  std::vector<std::string> files;
  for (const FileReport& file : data.report.files) files.push_back(file.name);
  const std::vector<std::string> likely = LikelySetPoints(data);
  std::vector<std::string> warnings;
  for (const auto* messages : {&data.obstacles, &data.warnings}) {
    for (const Message& message : *messages) warnings.push_back(message.text);
  }
  return OptionError(
      "change_times,tags",
      absl::StrCat(
          "there is nothing to learn from in ",
          files.empty() ? "the records" : absl::StrJoin(files, ", "),
          AnyMoves(data.records, &Record::set_points)
              ? ": no set point that changes rests long enough after it"
          : AnyMoves(data.records, &Record::inputs)
              ? ": no set point changes, and inputs that move may answer "
                "disturbances"
              : ": no set point changes, nor does any input move",
          ". Set points (columns <output>_setpoint) must change, or "
          "change_times must name the times (of an experiment, any in it)",
          likely.empty()
              ? ""
              : absl::StrCat("; of the columns that are ignored ",
                             ListOfNames(likely),
                             " may be set points, to be mapped by tags"),
          warnings.empty()
              ? ""
              : absl::StrCat(" (", absl::StrJoin(warnings, " "), ")")));
}

// Parts of the records in which every input is known, a settling time long at
// least; where none is, the longest part of each.
void TakeWholeRecords(RecordData& data) {
  for (std::size_t r = 0; r < data.records.size(); ++r) {
    std::vector<SampleRange> parts = WholeParts(data.records[r], data.lead);
    if (parts.empty()) parts = {WholeInputs(data.records[r])};
    for (const SampleRange& part : parts) {
      if (part.samples() < 2) continue;
      data.windows.push_back(WholeWindow(data.records[r], r));
      Cut(part, data.windows.back());
    }
  }
}

}  // namespace

absl::Status FindUsedWindows(const ProcessModel& model,
                             const RecordOptions& options, RecordData& data) {
  MLE_ASSIGN_OR_RETURN(WindowSet set,
                       FindWindows(data.records, model, options.windows));
  data.windows = std::move(set.windows);
  for (std::string& warning : set.warnings) {
    data.warnings.push_back(
        {MessageCode::kWindows, "", std::move(warning), {}});
  }
  MakeInputsWhole(model, data);
  const bool by_inputs = set.changes == 0 &&
                         options.windows.change_times.empty() &&
                         LikelySetPoints(data).empty() &&
                         !AnyMoves(data.records, &Record::set_points) &&
                         AnyMoves(data.records, &Record::inputs);
  if (by_inputs) {
    TakeWholeRecords(data);
    data.warnings.push_back(
        {MessageCode::kWindows,
         "",
         "no set point changes: the whole records are used, and moves of "
         "inputs stand for those of set points",
         {}});
  }
  MLE_RETURN_IF_ERROR(LeaveOutWindows(model, options.leave_out, data));
  // Nothing is corrected from records with obstacles, but they are shown.
  if (data.windows.empty() && !data.obstacles.empty()) TakeWholeRecords(data);
  if (data.windows.empty()) return NoWindows(data);
  return KeepInformativeWindows(model, options.most_samples, data);
}

}  // namespace mle
