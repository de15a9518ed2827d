#include "apps/correct/records.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "apps/correct/checksum.h"
#include "apps/report/number.h"
#include "mle/base/status.h"
#include "mle/nonlinear/output_reconstruction.h"

namespace mle::correct {
namespace {

using report::FormatInteger;

absl::Status OfData(const absl::Status& status) {
  return absl::Status(status.code(),
                      absl::StrCat("--data: ", status.message()));
}

// Of missing samples a warning is made only where they are many: the table of
// the channels has them all.
constexpr double kManyMissing = 0.05;

void AddImportWarnings(RecordData& data) {
  bool many = false;
  for (const ChannelReport& channel : data.report.channels) {
    many = many || static_cast<double>(channel.missing) >
                       kManyMissing * static_cast<double>(data.report.samples);
  }
  std::vector<std::string>& to = many ? data.warnings : data.notes;
  to.insert(to.end(), data.report.warnings.begin(), data.report.warnings.end());
}

// Finds what is wrong with the channels, and marks what is not to be used.
void MarkUnhealthy(const ProcessModel& model, const MarkOptions& mark,
                   RecordData& data) {
  data.health = CheckHealth(data.records, model, HealthOptions());
  for (const ChannelHealth& channel : data.health.channels) {
    if (channel.is_healthy()) continue;
    for (const absl::string_view line : absl::StrSplit(
             channel.Report(data.records), '\n', absl::SkipWhitespace())) {
      data.notes.emplace_back(absl::StripAsciiWhitespace(line));
    }
  }
  if (const int marked = MarkBad(data.health, mark, data.records); marked > 0) {
    data.notes.push_back(
        absl::StrCat(FormatInteger(marked),
                     " of these samples are taken as bad (--nomark_outliers, "
                     "--nomark_frozen keep them)."));
  }
}

// Samples first … last of a window.
struct Range {
  int first = 0;
  int last = -1;

  int samples() const { return last - first + 1; }
};

// The longest part in which every input is known.
Range WholeInputs(const Record& record) {
  Range best;
  int first = 0;
  for (int k = 0; k <= record.samples(); ++k) {
    if (k < record.samples() && record.inputs.col(k).array().isFinite().all()) {
      continue;
    }
    if (k - first > best.samples()) best = {first, k - 1};
    first = k + 1;
  }
  return best;
}

void Cut(Range range, SetPointWindow& window) {
  Record part;
  part.start_time = window.record.time(range.first);
  part.sample_time = window.record.sample_time;
  part.outputs = window.record.outputs.middleCols(range.first, range.samples());
  part.inputs = window.record.inputs.middleCols(range.first, range.samples());
  if (window.record.set_points.size() > 0) {
    part.set_points =
        window.record.set_points.middleCols(range.first, range.samples());
  }
  window.record = std::move(part);
  window.first_sample += range.first;
  std::vector<SetPointChange> changes;
  for (SetPointChange change : window.changes) {
    change.sample -= range.first;
    if (change.sample >= 0 && change.sample < range.samples()) {
      changes.push_back(change);
    }
  }
  window.changes = std::move(changes);
}

// Leaves out, or cuts, windows in which inputs are missing.
void MakeInputsWhole(const ProcessModel& model, RecordData& data) {
  std::vector<SetPointWindow> whole;
  for (SetPointWindow& window : data.windows) {
    const std::string name =
        absl::StrFormat("The window from %.7g to %.7g %s", BeginOf(window),
                        EndOf(window), model.time_unit());
    const Range range = WholeInputs(window.record);
    if (range.samples() == window.record.samples()) {
      whole.push_back(std::move(window));
      continue;
    }
    if (range.samples() > 0) Cut(range, window);
    if (range.samples() < 2 || window.changes.empty()) {
      data.warnings.push_back(absl::StrCat(
          name,
          " is left out: inputs are missing around its set-point change "
          "(--max_gap bridges gaps)."));
      continue;
    }
    data.warnings.push_back(
        absl::StrCat(name,
                     " is cut to its longest part without missing "
                     "inputs (--max_gap bridges gaps)."));
    whole.push_back(std::move(window));
  }
  data.windows = std::move(whole);
}

// Beyond what a controller makes of noise: it moves inputs in quiet parts too.
constexpr double kLargeUnrest = 3.0;  // of the noise's standard deviation

bool IsLarge(const QuietPart& part) {
  return std::abs(part.size) > kLargeUnrest * part.noise;
}

void WarnOfUnrest(const ProcessModel& model, RecordData& data) {
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    const std::vector<std::string> unrest = UnrestIn(data.windows[w], model);
    if (unrest.empty()) continue;
    data.warnings.push_back(absl::StrCat(
        "Window ", w + 1,
        " is not at rest where it should be: ", absl::StrJoin(unrest, ", "),
        ". A disturbance that was not measured widens the intervals."));
  }
}

absl::Status NoWindows(const std::vector<std::string>& paths,
                       const RecordData& data) {
  return absl::InvalidArgumentError(absl::StrCat(
      "--data: there is nothing to learn from in ", absl::StrJoin(paths, ", "),
      ": no set point changes. Columns <output>_setpoint must hold changes, or "
      "--change_times name them",
      data.warnings.empty()
          ? ""
          : absl::StrCat(" (", absl::StrJoin(data.warnings, " "), ")")));
}

}  // namespace

std::vector<Record> RecordData::Records() const {
  std::vector<Record> result;
  for (const SetPointWindow& window : windows) result.push_back(window.record);
  return result;
}

double BeginOf(const SetPointWindow& window) { return window.record.time(0); }

double EndOf(const SetPointWindow& window) {
  return window.record.time(window.record.samples() - 1);
}

std::vector<std::string> UnrestIn(const SetPointWindow& window,
                                  const ProcessModel& model) {
  std::vector<std::string> unrest;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (const auto* parts : {&window.before, &window.after}) {
      if (i >= static_cast<int>(parts->size())) continue;
      const QuietPart& part = (*parts)[i];
      const bool drifts = part.verdict == QuietPart::Verdict::kDrifting;
      const bool steps = part.verdict == QuietPart::Verdict::kDisturbed;
      if (!IsLarge(part) || (!drifts && !steps)) continue;
      unrest.push_back(absl::StrCat(
          model.outputs()[i].name, drifts ? " drifts" : " steps",
          parts == &window.before ? " before the change" : " at the end"));
    }
  }
  return unrest;
}

absl::StatusOr<RecordData> LoadRecords(const std::vector<std::string>& paths,
                                       const ProcessModel& model,
                                       const RecordOptions& options) {
  RecordData data;
  for (const std::string& path : paths) {
    absl::StatusOr<FileChecksum> checksum = ChecksumOf(path);
    if (!checksum.ok()) return OfData(checksum.status());
    data.files.push_back({path, checksum->sha256, checksum->bytes});
  }
  absl::StatusOr<HistorianImport> import =
      ImportHistorian(paths, model, options.import);
  if (!import.ok()) return OfData(import.status());
  data.records = std::move(import->records);
  data.report = std::move(import->report);
  AddImportWarnings(data);
  MarkUnhealthy(model, options.mark, data);
  MLE_ASSIGN_OR_RETURN(WindowSet set,
                       FindWindows(data.records, model, options.windows));
  data.windows = std::move(set.windows);
  for (std::string& warning : set.warnings) {
    data.warnings.push_back(std::move(warning));
  }
  MakeInputsWhole(model, data);
  if (data.windows.empty()) return NoWindows(paths, data);
  WarnOfUnrest(model, data);
  return data;
}

absl::Status MarkOutliersByModel(const ProcessModel& model,
                                 const StructuredOptions& structured,
                                 RecordData& data) {
  std::vector<Record> records = data.Records();
  const OutlierMarkOptions options;
  MLE_ASSIGN_OR_RETURN(const OutlierReport report,
                       MarkOutliers(model, structured, options, records));
  for (std::size_t w = 0; w < records.size(); ++w) {
    data.windows[w].record = std::move(records[w]);
  }
  data.outliers_by_model = report.marked;
  for (int i = 0; i < model.num_outputs(); ++i) {
    const std::string& name = model.outputs()[i].name;
    if (report.marked[i] > 0) {
      data.notes.push_back(absl::StrCat(
          name, ": ", FormatInteger(report.marked[i]),
          " samples of the windows that the model does not believe, at most ",
          report.longest[i],
          " in a row, are taken as bad (--nomark_outliers keeps them)."));
    }
    if (report.left[i] > 0) {
      data.warnings.push_back(absl::StrCat(
          name, ": ", FormatInteger(report.left[i]),
          " samples are as far from what the model expects as outliers are, "
          "but more than ",
          options.longest_burst,
          " in a row: a disturbance that was not measured. They are used."));
    }
  }
  return absl::OkStatus();
}

}  // namespace mle::correct
