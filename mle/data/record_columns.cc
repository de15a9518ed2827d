#include "mle/data/record_columns.h"

#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;
using ColumnsByName = std::map<std::string, RecordColumn, std::less<>>;

constexpr std::string_view kSetPointSuffix = "_setpoint";

std::string SetPointName(const std::string& output) {
  return output + std::string(kSetPointSuffix);
}

std::string Quoted(std::string_view name) {
  return absl::StrCat("'", ShowCsvText(name), "'");
}

// Columns by their names in the file.
absl::StatusOr<ColumnsByName> NameColumns(const ProcessModel& channels,
                                          const ColumnOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> known,
                       ColumnsOf(channels));
  std::map<std::string, const TagMapping*> mapped;
  for (const TagMapping& tag : options.tags) mapped[tag.channel] = &tag;
  ColumnsByName columns;
  for (RecordColumn column : known) {
    const auto found = mapped.find(column.name);
    if (column.kind == Kind::kTime) {
      column.name = options.time_column;
    } else if (found != mapped.end()) {
      column.name = found->second->tag;
      column.scale = found->second->scale;
      column.offset = found->second->offset;
    }
    if (!columns.emplace(column.name, column).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("a column ", Quoted(column.name),
                       " would be two channels; map the tags otherwise"));
    }
  }
  return columns;
}

// Joins quality columns to those they speak of.
void MatchQuality(const ColumnOptions& options,
                  std::vector<RecordColumn>& columns) {
  std::map<std::string, int, std::less<>> samples;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const Kind kind = columns[c].kind;
    if (kind == Kind::kOther || kind == Kind::kTime) continue;
    samples[columns[c].name] = static_cast<int>(c);
  }
  for (RecordColumn& column : columns) {
    if (column.kind != Kind::kOther) continue;
    for (const std::string& suffix : options.quality_suffixes) {
      if (suffix.empty() || !column.name.ends_with(suffix)) continue;
      const auto found =
          samples.find(std::string_view(column.name)
                           .substr(0, column.name.size() - suffix.size()));
      if (found == samples.end()) continue;
      column.kind = Kind::kQuality;
      column.quality_of = found->second;
    }
  }
}

absl::Status CheckOthers(const std::vector<RecordColumn>& columns,
                         const ColumnOptions& options) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::string& name = columns[c].name;
    if (columns[c].kind != Kind::kOther) continue;
    const bool is_set_point = name.ends_with(kSetPointSuffix);
    if (options.ignore_other_columns && !is_set_point) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "column ", c + 1, ": ", Quoted(name),
        is_set_point
            ? " is a set point of an output that the process model does not "
              "have"
            : " is neither time nor an input, output or set point of the "
              "process model; other columns are errors unless they are to be "
              "ignored"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ColumnOptions::Validate(const ProcessModel& channels) const {
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> known,
                       ColumnsOf(channels));
  std::set<std::string> free;
  for (const RecordColumn& column : known) {
    if (column.kind != Kind::kTime) free.insert(column.name);
  }
  for (const TagMapping& tag : tags) {
    const std::string place =
        absl::StrCat("tag ", Quoted(tag.tag), " for ", Quoted(tag.channel));
    if (free.erase(tag.channel) == 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(place,
                       ": the process model has no such input, output or "
                       "<output>_setpoint, or it is mapped twice"));
    }
    if (tag.tag.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat(place, ": a tag needs a name"));
    }
    if (!std::isfinite(tag.scale) || tag.scale == 0.0 ||
        !std::isfinite(tag.offset)) {
      return absl::InvalidArgumentError(
          absl::StrCat(place, ": scale is ", tag.scale, " and offset ",
                       tag.offset, "; both must be finite, the scale not 0"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<RecordColumn>> ColumnsOf(
    const ProcessModel& channels) {
  std::vector<RecordColumn> columns(1);
  columns[0].kind = Kind::kTime;
  columns[0].name = "time";
  const auto add = [&](Kind kind, int channel, std::string name) {
    RecordColumn& column = columns.emplace_back();
    column.kind = kind;
    column.channel = channel;
    column.name = std::move(name);
  };
  for (int i = 0; i < channels.num_outputs(); ++i) {
    const std::string& name = channels.outputs()[i].name;
    add(Kind::kOutput, i, name);
    add(Kind::kSetPoint, i, SetPointName(name));
  }
  for (int j = 0; j < channels.num_inputs(); ++j) {
    add(Kind::kInput, j, channels.inputs()[j].name);
  }
  std::set<std::string> names;
  for (const RecordColumn& column : columns) {
    if (names.insert(column.name).second) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "the process model has a channel '", column.name,
        "', which in a record is the name of another column (time, or the set "
        "point of an output); rename the channel"));
  }
  return columns;
}

absl::StatusOr<std::vector<RecordColumn>> MatchHeader(
    const std::vector<std::string_view>& header, const ProcessModel& channels,
    const ColumnOptions& options) {
  MLE_ASSIGN_OR_RETURN(ColumnsByName missing, NameColumns(channels, options));
  std::vector<RecordColumn> columns;
  std::set<std::string> seen;
  for (std::size_t c = 0; c < header.size(); ++c) {
    const bool is_exact = missing.find(header[c]) != missing.end();
    const std::string name(is_exact ? header[c] : TrimCsvField(header[c]));
    const auto found = missing.find(name);
    if (!seen.insert(name).second &&
        !(name.empty() && options.ignore_other_columns)) {
      return absl::InvalidArgumentError(
          absl::StrCat("column ", c + 1, ": ", Quoted(name), " stands twice"));
    }
    if (found != missing.end()) {
      columns.push_back(std::move(found->second));
      missing.erase(found);
    } else {
      columns.emplace_back().name = name;
    }
  }
  std::vector<std::string> needed;
  for (const auto& [name, column] : missing) {
    if (column.kind != Kind::kSetPoint) needed.push_back(Quoted(name));
  }
  if (!needed.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("there is no column ", absl::StrJoin(needed, ", "),
                     "; the header must name time and every input and output"));
  }
  MatchQuality(options, columns);
  MLE_RETURN_IF_ERROR(CheckOthers(columns, options));
  return columns;
}

}  // namespace mle
