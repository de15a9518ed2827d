#include "mle/data/record_columns.h"

#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

constexpr std::string_view kSetPointSuffix = "_setpoint";

std::string SetPointName(const std::string& output) {
  return output + std::string(kSetPointSuffix);
}

}  // namespace

absl::StatusOr<std::vector<RecordColumn>> ColumnsOf(
    const ProcessModel& channels) {
  std::vector<RecordColumn> columns = {{Kind::kTime, 0, "time"}};
  for (int i = 0; i < channels.num_outputs(); ++i) {
    const std::string& name = channels.outputs()[i].name;
    columns.push_back({Kind::kOutput, i, name});
    columns.push_back({Kind::kSetPoint, i, SetPointName(name)});
  }
  for (int j = 0; j < channels.num_inputs(); ++j) {
    columns.push_back({Kind::kInput, j, channels.inputs()[j].name});
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
    const std::vector<std::string>& header, const ProcessModel& channels) {
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> known,
                       ColumnsOf(channels));
  std::map<std::string, RecordColumn> missing;
  for (const RecordColumn& column : known) missing[column.name] = column;

  std::vector<RecordColumn> columns;
  std::set<std::string> seen;
  for (std::size_t c = 0; c < header.size(); ++c) {
    const bool is_exact = missing.find(header[c]) != missing.end();
    const std::string name =
        is_exact ? header[c] : std::string(TrimCsvField(header[c]));
    if (!seen.insert(name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("column ", c + 1, ": '", name, "' stands twice"));
    }
    const auto found = missing.find(name);
    if (found != missing.end()) {
      columns.push_back(std::move(found->second));
      missing.erase(found);
    } else if (name.ends_with(kSetPointSuffix)) {
      return absl::InvalidArgumentError(
          absl::StrCat("column ", c + 1, ": '", name,
                       "' is the set point of no output of the process model"));
    } else {
      columns.push_back({Kind::kOther, 0, name});
    }
  }
  std::vector<std::string> needed;
  for (const auto& [name, column] : missing) {
    if (column.kind != Kind::kSetPoint) {
      needed.push_back(absl::StrCat("'", name, "'"));
    }
  }
  if (needed.empty()) return columns;
  return absl::InvalidArgumentError(
      absl::StrCat("there is no column ", absl::StrJoin(needed, ", "),
                   "; the header must name time and every input and output"));
}

}  // namespace mle
