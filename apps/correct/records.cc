#include "apps/correct/records.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/correct/checksum.h"
#include "apps/report/number.h"
#include "mle/base/status.h"
#include "mle/data/record_csv.h"

namespace mle::correct {
namespace {

using report::FormatInteger;
using report::FormatSignificant;

// Without trailing zeros.
std::string FormatTime(double time) { return absl::StrFormat("%.7g", time); }

absl::Status During(const std::string& what, const absl::Status& status) {
  return absl::Status(status.code(),
                      absl::StrCat(what, ": ", status.message()));
}

// Holds the value before through runs of lost samples of up to `longest`; how
// many were filled.
int BridgeInputs(int longest, Record& record) {
  int filled = 0;
  for (int j = 0; j < record.num_inputs(); ++j) {
    auto input = record.inputs.row(j);
    for (int k = 1; k < record.samples(); ++k) {
      if (std::isfinite(input(k))) continue;
      int end = k;
      while (end < record.samples() && !std::isfinite(input(end))) ++end;
      if (std::isfinite(input(k - 1)) && end - k <= longest) {
        input.segment(k, end - k).setConstant(input(k - 1));
        filled += end - k;
      }
      k = end;
    }
  }
  return filled;
}

absl::StatusOr<Source> ReadSource(const std::string& path,
                                  const ProcessModel& model,
                                  const RecordOptions& options) {
  Source source;
  source.path = path;
  MLE_ASSIGN_OR_RETURN(FileChecksum checksum, ChecksumOf(path));
  source.sha256 = std::move(checksum.sha256);
  source.bytes = checksum.bytes;
  MLE_ASSIGN_OR_RETURN(
      source.record,
      ReadRecordCsv(path, model, {.bad_values = options.bad_values}));
  return source;
}

// Sample ranges [first, last] of the windows of one record: changes whose
// windows overlap share one.
struct Range {
  int first = 0;
  int last = 0;
  std::vector<SetPointChange> changes;
};

std::vector<Range> FindRanges(const Record& record, double before,
                              double after) {
  const int n = record.samples();
  const auto samples = [&](double time) {
    return static_cast<int>(
        std::min<double>(std::round(time / record.sample_time), n));
  };
  std::vector<Range> ranges;
  for (const SetPointChange& change : FindSetPointChanges(record)) {
    const int first = std::max(change.sample - samples(before), 0);
    const int last = std::min(change.sample + samples(after), n - 1);
    if (ranges.empty() || first > ranges.back().last) {
      ranges.push_back({first, last, {}});
    }
    ranges.back().last = std::max(ranges.back().last, last);
    ranges.back().changes.push_back(change);
  }
  return ranges;
}

// The longest part of `range` in which every input is known.
Range WholeInputs(const Record& record, const Range& range) {
  Range best = {range.first, range.first - 1, {}};
  int first = range.first;
  for (int k = range.first; k <= range.last + 1; ++k) {
    const bool ends =
        k > range.last || !record.inputs.col(k).array().isFinite().all();
    if (!ends) continue;
    if (k - first > best.last - best.first + 1) {
      best.first = first;
      best.last = k - 1;
    }
    first = k + 1;
  }
  for (const SetPointChange& change : range.changes) {
    if (change.sample >= best.first && change.sample <= best.last) {
      best.changes.push_back(change);
    }
  }
  return best;
}

Record Cut(const Record& record, int first, int last) {
  const int count = last - first + 1;
  Record part;
  part.start_time = record.time(first);
  part.sample_time = record.sample_time;
  part.outputs = record.outputs.middleCols(first, count);
  part.inputs = record.inputs.middleCols(first, count);
  part.set_points = record.set_points.middleCols(first, count);
  return part;
}

void AddWindows(int source, const RecordOptions& options,
                const ProcessModel& model, RecordData& data) {
  const Record& record = data.sources[source].record;
  const double settling = SettlingTime(model);
  const double before =
      options.window_before > 0.0 ? options.window_before : settling;
  const double after =
      options.window_after > 0.0 ? options.window_after : settling;
  for (const Range& wanted : FindRanges(record, before, after)) {
    const Range range = WholeInputs(record, wanted);
    const std::string name = absl::StrCat(
        data.sources[source].path, ": the window from ",
        FormatTime(record.time(wanted.first)), " to ",
        FormatTime(record.time(wanted.last)), " ", model.time_unit());
    if (range.changes.empty()) {
      data.warnings.push_back(absl::StrCat(
          name,
          " is left out: inputs are missing around its set-point change"));
      continue;
    }
    if (range.first != wanted.first || range.last != wanted.last) {
      data.warnings.push_back(
          absl::StrCat(name, " is cut where inputs are missing"));
    }
    Window window;
    window.source = source;
    window.record = Cut(record, range.first, range.last);
    window.changes = range.changes;
    for (SetPointChange& change : window.changes) change.sample -= range.first;
    data.windows.push_back(std::move(window));
  }
}

absl::Status CheckSampleTimes(const RecordData& data) {
  const Source& first = data.sources.front();
  for (const Source& source : data.sources) {
    if (std::abs(source.record.sample_time - first.record.sample_time) >
        1e-6 * first.record.sample_time) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "--data: %s has a sample time of %g, %s one of %g; they must be the "
          "same",
          source.path, source.record.sample_time, first.path,
          first.record.sample_time));
    }
  }
  return absl::OkStatus();
}

struct ChannelSummary {
  double lost = 0.0;
  double samples = 0.0;
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  void Add(const Eigen::RowVectorXd& values) {
    for (const double value : values) {
      samples += 1.0;
      if (!std::isfinite(value)) {
        lost += 1.0;
        continue;
      }
      min = std::min(min, value);
      max = std::max(max, value);
    }
  }
};

std::string Describe(const SetPointChange& change, const ProcessModel& model) {
  return absl::StrCat(model.outputs()[change.output].name, " ",
                      FormatSignificant(change.from, 4), " → ",
                      FormatSignificant(change.to, 4));
}

}  // namespace

std::vector<Record> RecordData::Records() const {
  std::vector<Record> records;
  for (const Window& window : windows) records.push_back(window.record);
  return records;
}

double SettlingTime(const ProcessModel& model) {
  double longest = 0.0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& element = model.element(i, j);
      if (element.IsZero()) continue;
      longest = std::max(longest,
                         element.delay() + 5.0 * element.SlowestTimeConstant());
    }
  }
  return longest;
}

absl::StatusOr<RecordData> LoadRecords(const std::vector<std::string>& paths,
                                       const ProcessModel& model,
                                       const RecordOptions& options) {
  RecordData data;
  for (const std::string& path : paths) {
    absl::StatusOr<Source> source = ReadSource(path, model, options);
    if (!source.ok()) return During("--data", source.status());
    if (const int filled = BridgeInputs(options.longest_bridge, source->record);
        filled > 0) {
      data.notes.push_back(absl::StrCat(
          path, ": ", FormatInteger(filled),
          " lost samples of inputs take the value before (--longest_bridge)"));
    }
    data.sources.push_back(*std::move(source));
  }
  MLE_RETURN_IF_ERROR(CheckSampleTimes(data));
  for (std::size_t s = 0; s < data.sources.size(); ++s) {
    AddWindows(static_cast<int>(s), options, model, data);
  }
  if (data.windows.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--data: no set point changes in ", absl::StrJoin(paths, ", "),
        "; columns <output>_setpoint must hold changes, outside of which a "
        "loop hardly moves and tells nothing"));
  }
  if (data.windows.size() == 1) {
    data.warnings.push_back(
        "There is a single window: a correction cannot be tried on a set-point "
        "change it has not seen, and what the change did not excite stays "
        "unknown. Parts of the window are held out instead.");
  }
  return data;
}

report::Table SourceTable(const RecordData& data, const ProcessModel& model) {
  report::Table table;
  table.caption = "Records";
  table.columns = {{"file", report::Align::kLeft},
                   {"samples"},
                   {absl::StrCat("sample time (", model.time_unit(), ")")},
                   {absl::StrCat("from (", model.time_unit(), ")")},
                   {"to"},
                   {"SHA-256", report::Align::kLeft}};
  for (const Source& source : data.sources) {
    const Record& record = source.record;
    table.AddRow({source.path, FormatInteger(record.samples()),
                  FormatTime(record.sample_time), FormatTime(record.time(0)),
                  FormatTime(record.time(record.samples() - 1)),
                  source.sha256.substr(0, 12) + "…"});
  }
  return table;
}

report::Table ChannelTable(const RecordData& data, const ProcessModel& model) {
  report::Table table;
  table.caption = "Channels";
  table.columns = {{"channel", report::Align::kLeft},
                   {"kind", report::Align::kLeft},
                   {"unit", report::Align::kLeft},
                   {"smallest"},
                   {"largest"},
                   {"lost samples"}};
  const auto add = [&](const std::string& name, const char* kind,
                       const std::string& unit, const auto& row_of) {
    ChannelSummary summary;
    for (const Source& source : data.sources)
      summary.Add(row_of(source.record));
    table.AddRow(
        {name, kind, unit, FormatSignificant(summary.min, 4),
         FormatSignificant(summary.max, 4),
         absl::StrFormat("%.2f %%", 100.0 * summary.lost /
                                        std::max(summary.samples, 1.0))});
  };
  for (int i = 0; i < model.num_outputs(); ++i) {
    add(model.outputs()[i].name, "output", model.outputs()[i].unit,
        [i](const Record& record) { return record.outputs.row(i); });
  }
  for (int j = 0; j < model.num_inputs(); ++j) {
    add(model.inputs()[j].name, "input", model.inputs()[j].unit,
        [j](const Record& record) { return record.inputs.row(j); });
  }
  return table;
}

report::Table WindowTable(const RecordData& data, const ProcessModel& model) {
  report::Table table;
  table.caption = "Windows around set-point changes";
  table.columns = {{"window"},
                   {"file", report::Align::kLeft},
                   {absl::StrCat("from (", model.time_unit(), ")")},
                   {"to"},
                   {"samples"},
                   {"set-point changes", report::Align::kLeft}};
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    const Window& window = data.windows[w];
    std::vector<std::string> changes;
    for (const SetPointChange& change : window.changes) {
      changes.push_back(Describe(change, model));
    }
    table.AddRow({absl::StrCat(w + 1), data.sources[window.source].path,
                  FormatTime(window.begin()), FormatTime(window.end()),
                  FormatInteger(window.record.samples()),
                  absl::StrJoin(changes, ", ")});
  }
  return table;
}

}  // namespace mle::correct
