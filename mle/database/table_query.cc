#include "mle/database/table_query.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/time/time.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/data/nearest_names.h"
#include "mle/data/time_columns.h"
#include "mle/data/time_range.h"

namespace mle {
namespace {

constexpr std::size_t kShownColumns = 10;
// More than zones differ.
constexpr double kDaySeconds = 86400.0;
// Dates as text are read for a day more at the end, as "2024-03-04T…" is after
// "2024-03-04 …".
constexpr double kMoreForText = kDaySeconds;
// Dates that stand for a limit that is not given.
constexpr char kEarliest[] = "0001-01-01 00:00:00";
constexpr char kLatest[] = "9999-12-31 23:59:59";

std::string Listed(const std::vector<std::string>& names) {
  std::vector<std::string> shown;
  for (const std::string& name : names) {
    if (shown.size() == kShownColumns) {
      shown.push_back(absl::StrCat("… (", names.size(), ")"));
      break;
    }
    shown.push_back(absl::StrCat("'", ShowCsvText(name), "'"));
  }
  return absl::StrJoin(shown, ", ");
}

// " (nearest: 'trend')", or nothing.
std::string Nearest(const std::string& name,
                    const std::vector<std::string>& names) {
  const std::vector<std::string> near = NearestNames(name, names);
  return near.empty() ? "" : absl::StrCat(" (nearest: ", Listed(near), ")");
}

int Find(const std::vector<SqlColumn>& columns, const std::string& name) {
  for (const bool is_exact : {true, false}) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (is_exact ? columns[c].name == name
                   : FoldedName(columns[c].name) == FoldedName(name)) {
        return static_cast<int>(c);
      }
    }
  }
  return -1;
}

// The column of times, by the declared name or a usual one; −1: none.
int FindTime(const std::vector<SqlColumn>& columns,
             const ColumnOptions& options) {
  const int declared = Find(columns, options.time_column);
  if (declared >= 0 || options.time_column != ColumnOptions().time_column) {
    return declared;
  }
  for (const std::string& name : UsualTimeColumns()) {
    const int found = Find(columns, name);
    if (found >= 0) return found;
  }
  return -1;
}

// Places of the columns that are read.
absl::StatusOr<std::vector<int>> Choose(const DatabaseOptions& database,
                                        const std::vector<SqlColumn>& columns,
                                        int time) {
  std::vector<int> chosen;
  if (time >= 0) chosen.push_back(time);
  std::vector<std::string> faults;
  std::vector<std::string> names;
  for (const SqlColumn& column : columns) names.push_back(column.name);
  for (const std::string& name : database.columns) {
    const int found = Find(columns, name);
    if (found < 0) {
      faults.push_back(
          absl::StrCat("'", ShowCsvText(name), "'", Nearest(name, names)));
    } else if (std::find(chosen.begin(), chosen.end(), found) == chosen.end()) {
      chosen.push_back(found);
    }
  }
  if (faults.empty()) return chosen;
  return OptionError(
      "columns",
      absl::StrCat("the table has no column ", absl::StrJoin(faults, ", "),
                   "; it has ", Listed(names), "; declare them as columns = ",
                   ShowCsvText(names.empty() ? "" : names[0]), ",…"));
}

std::string DateOf(double seconds) {
  return absl::FormatTime(
      "%Y-%m-%d %H:%M:%S",
      absl::UnixEpoch() + absl::Seconds(std::floor(seconds)),
      absl::UTCTimeZone());
}

absl::StatusOr<TimeRange> RangeOf(const HistorianOptions& import) {
  return TimeRange::Create(
      import.begin, import.end,
      import.clocks.empty() ? import.clock : import.clocks[0]);
}

// " WHERE …"; empty where the database cannot compare dates.
absl::StatusOr<std::string> ConditionOf(const HistorianOptions& import,
                                        const SqlColumn& time,
                                        const std::string& table,
                                        const std::string& name,
                                        DatabaseSession& session) {
  MLE_ASSIGN_OR_RETURN(const TimeRange range, RangeOf(import));
  if (!range.begin_seconds() && !range.end_seconds()) return std::string();
  double more = 0.0;
  if (!time.is_date) {
    MLE_ASSIGN_OR_RETURN(const bool text, session.HasTextDates(table, name));
    if (!text) return std::string();
    more = kMoreForText;
  }
  std::vector<std::string> limits;
  const auto add = [&](const char* comparison, std::optional<double> seconds) {
    if (!seconds) return;
    const std::string literal = session.DateLiteral(DateOf(*seconds));
    if (!literal.empty()) {
      limits.push_back(absl::StrCat(name, " ", comparison, " ", literal));
    }
  };
  if (range.begin_seconds()) add(">=", *range.begin_seconds() - kDaySeconds);
  if (range.end_seconds()) {
    add("<=", *range.end_seconds() + kDaySeconds + more);
  }
  return limits.empty() ? "" : " WHERE " + absl::StrJoin(limits, " AND ");
}

}  // namespace

absl::StatusOr<std::vector<std::string>> PartsOfTable(
    const std::string& table) {
  std::vector<std::string> parts(1);
  bool is_quoted = false;
  bool is_valid = true;
  bool has_ended = false;  // a part in quotes
  for (std::size_t k = 0; k < table.size(); ++k) {
    const char c = table[k];
    if (is_quoted && c == '"' && k + 1 < table.size() && table[k + 1] == '"') {
      parts.back() += table[k++];
    } else if (c == '"') {
      is_valid = is_valid && (is_quoted || parts.back().empty());
      has_ended = is_quoted;
      is_quoted = !is_quoted;
    } else if (c == '.' && !is_quoted) {
      parts.emplace_back();
      has_ended = false;
    } else {
      is_valid = is_valid && !has_ended && c != '\0';
      parts.back() += c;
    }
  }
  is_valid = is_valid && !is_quoted &&
             std::none_of(parts.begin(), parts.end(),
                          [](const std::string& part) { return part.empty(); });
  if (is_valid) return parts;
  return OptionError(
      "table",
      absl::StrCat("table = ", ShowCsvText(table),
                   " is not the name of a table such as trend, plant.trend or "
                   "plant.\"my.table\""));
}

absl::StatusOr<std::string> WithLimits(const std::string& query,
                                       const HistorianOptions& import) {
  MLE_ASSIGN_OR_RETURN(const TimeRange range, RangeOf(import));
  return absl::StrReplaceAll(
      query, {{kBeginPlace, range.begin_seconds()
                                ? DateOf(*range.begin_seconds() - kDaySeconds)
                                : kEarliest},
              {kEndPlace, range.end_seconds()
                              ? DateOf(*range.end_seconds() + kDaySeconds)
                              : kLatest}});
}

absl::StatusOr<std::string> TableQuery(const DatabaseOptions& database,
                                       const HistorianOptions& import,
                                       DatabaseSession& session) {
  MLE_ASSIGN_OR_RETURN(std::vector<std::string> parts,
                       PartsOfTable(database.table));
  for (std::string& part : parts) {
    MLE_ASSIGN_OR_RETURN(part, session.Quote(part));
  }
  const std::string table = absl::StrJoin(parts, ".");
  const absl::StatusOr<std::vector<SqlColumn>> columns =
      session.Start(absl::StrCat("SELECT * FROM ", table, " WHERE 1 = 0"));
  if (!columns.ok()) {
    const std::vector<std::string> tables = session.Tables();
    const bool is_there =
        std::find(tables.begin(), tables.end(), database.table) != tables.end();
    if (tables.empty() || is_there ||
        columns.status().code() != absl::StatusCode::kInvalidArgument) {
      return columns.status();
    }
    return OptionError(
        "table",
        absl::StrCat(columns.status().message(),
                     ": table = ", ShowCsvText(database.table),
                     " is not in the database", Nearest(database.table, tables),
                     ", which has ", Listed(tables)));
  }
  const int time = FindTime(*columns, import.columns);
  MLE_ASSIGN_OR_RETURN(const std::vector<int> chosen,
                       Choose(database, *columns, time));
  std::vector<std::string> names;
  for (const int c : chosen) {
    MLE_ASSIGN_OR_RETURN(names.emplace_back(),
                         session.Quote((*columns)[c].name));
  }
  std::string query = absl::StrCat(
      "SELECT ", database.columns.empty() ? "*" : absl::StrJoin(names, ", "),
      " FROM ", table);
  if (time < 0) return query;
  MLE_ASSIGN_OR_RETURN(
      const std::string range,
      ConditionOf(import, (*columns)[time], table, names[0], session));
  MLE_ASSIGN_OR_RETURN(const std::string order, session.Order(table, names[0]));
  return absl::StrCat(query, range, order.empty() ? "" : " ORDER BY ", order);
}

}  // namespace mle
