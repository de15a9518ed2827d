#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"

namespace mle::correct {
namespace {

using report::Align;
using report::FormatInteger;
using report::FormatSignificant;
using report::Table;

// Without trailing zeros.
std::string FormatTime(double time) { return absl::StrFormat("%.7g", time); }

std::string Describe(const SetPointChange& change, const std::string& time,
                     const ProcessModel& model) {
  if (change.output < 0) return absl::StrCat("at ", time);
  return absl::StrCat(model.outputs()[change.output].name, " ",
                      FormatSignificant(change.from, 4), " → ",
                      FormatSignificant(change.to, 4));
}

struct ChannelRange {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
};

template <typename Function>
ChannelRange RangeOf(const RecordData& data, const Function& row_of) {
  ChannelRange range;
  for (const Record& record : data.records) {
    for (const double value : row_of(record)) {
      if (!std::isfinite(value)) continue;
      range.min = std::min(range.min, value);
      range.max = std::max(range.max, value);
    }
  }
  return range;
}

// The channel of the report; null where the files have no such channel.
const ChannelReport* FindChannel(const RecordData& data,
                                 const std::string& name) {
  for (const ChannelReport& channel : data.report.channels) {
    if (channel.name == name) return &channel;
  }
  return nullptr;
}

}  // namespace

std::string TimeUnit(const RecordData& data, const ProcessModel& model) {
  const TimeNames times = data.Times(model);
  return times.has_dates() && data.report.time_zone.empty() ? "as recorded"
                                                            : times.unit();
}

Table FileTable(const RecordData& data, const std::vector<DataFile>& files,
                const ProcessModel& model) {
  const TimeNames times = data.Times(model);
  Table table{.caption = absl::StrCat("Files, sampled every ",
                                      FormatTime(data.sample_time()), " ",
                                      model.time_unit(), " for the correction"),
              .columns = {{"file", Align::kLeft},
                          {"rows"},
                          {absl::StrCat("from (", TimeUnit(data, model), ")")},
                          {"to"},
                          {"SHA-256", Align::kLeft}}};
  for (const FileReport& file : data.report.files) {
    std::string sha256;
    for (const DataFile& one : files) {
      const bool is_input = one.path == "-" && file.name == kStandardInput;
      if (one.path == file.name || is_input)
        sha256 = one.sha256.substr(0, 12) + "…";
    }
    table.AddRow({file.name, FormatInteger(file.rows),
                  times.Short(file.first_time), times.Short(file.last_time),
                  sha256});
  }
  return table;
}

Table ChannelTable(const RecordData& data, const ProcessModel& model) {
  Table table{.caption = "Channels",
              .columns = {{"channel", Align::kLeft},
                          {"kind", Align::kLeft},
                          {"unit", Align::kLeft},
                          {"smallest"},
                          {"largest"},
                          {"bad in files"},
                          {"bridged samples"},
                          {"outlying"},
                          {"frozen"},
                          {"missing samples"}}};
  const auto add = [&](const std::string& name, const char* kind,
                       const std::string& unit, ChannelRange range,
                       const ChannelHealth& health) {
    const ChannelReport* const channel = FindChannel(data, name);
    table.AddRow(
        {name, kind, unit, FormatSignificant(range.min, 4),
         FormatSignificant(range.max, 4),
         channel != nullptr ? FormatInteger(channel->bad.total()) : "–",
         channel != nullptr ? FormatInteger(channel->bridged) : "–",
         FormatInteger(static_cast<std::int64_t>(health.outliers.size())),
         FormatInteger(health.frozen_samples()),
         channel != nullptr ? FormatInteger(channel->missing) : "–"});
  };
  for (int i = 0; i < model.num_outputs(); ++i) {
    const OutputChannel& output = model.outputs()[i];
    add(output.name, "output", output.unit,
        RangeOf(data, [i](const Record& r) { return r.outputs.row(i).eval(); }),
        data.health.channels[i]);
  }
  for (int j = 0; j < model.num_inputs(); ++j) {
    const InputChannel& input = model.inputs()[j];
    add(input.name, "input", input.unit,
        RangeOf(data, [j](const Record& r) { return r.inputs.row(j).eval(); }),
        data.health.channels[model.num_outputs() + j]);
  }
  return table;
}

Table WindowTable(const RecordData& data, const ProcessModel& model) {
  const TimeNames times = data.Times(model);
  Table table{.caption = "Windows around set-point changes",
              .columns = {{"window"},
                          {absl::StrCat("from (", TimeUnit(data, model), ")")},
                          {"to"},
                          {absl::StrCat("length (", model.time_unit(), ")")},
                          {"set-point changes", Align::kLeft},
                          {"remarks", Align::kLeft}},
              .stacked = true};
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    const SetPointWindow& window = data.windows[w];
    std::vector<std::string> changes;
    for (const SetPointChange& change : window.changes) {
      changes.push_back(Describe(
          change, times.Short(window.record.time(change.sample)), model));
    }
    std::vector<std::string> remarks;
    if (window.clipped_before) remarks.push_back("short before");
    if (window.clipped_after) remarks.push_back("short after");
    for (std::string& non_stationary : NonStationaryIn(window, model)) {
      remarks.push_back(std::move(non_stationary));
    }
    table.AddRow({absl::StrCat(w + 1), times.Short(BeginOf(window)),
                  times.Short(EndOf(window)),
                  FormatSignificant(EndOf(window) - BeginOf(window), 4),
                  absl::StrJoin(changes, ", "), absl::StrJoin(remarks, ", ")});
  }
  return table;
}

}  // namespace mle::correct
