#include "mle/data/long_table.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/nearest_names.h"
#include "mle/data/quality_columns.h"
#include "mle/data/time_columns.h"

namespace mle {
namespace {

const std::vector<std::string>& UsualTags() {
  static const auto& names = *new std::vector<std::string>{
      "tag",       "tagname",   "tag_name",  "tagid",  "point",
      "pointname", "pointid",   "name",      "item",   "signal",
      "variable",  "_field",    "entity_id", "itemid", "fulltagname",
      "varname",   "parameter", "metric",    "sensor", "attribute"};
  return names;
}

// The first that a header has.
const std::vector<std::string>& UsualValues() {
  static const auto& names = *new std::vector<std::string>{
      "value",    "val",      "_value",      "vvalue",     "tagval",
      "tagvalue", "pv",       "doublevalue", "floatvalue", "numericvalue",
      "reading",  "varvalue", "result",      "state",      "ip_trend_value"};
  return names;
}

int IndexOf(const std::vector<std::string>& header, const std::string& name) {
  for (std::size_t c = 0; c < header.size(); ++c) {
    if (FoldedName(header[c]) == FoldedName(name)) return static_cast<int>(c);
  }
  return -1;
}

// The column of a declared name, or of the first usual one; −1: none.
int Find(const std::vector<std::string>& header, const std::string& declared,
         const std::vector<std::string>& usual) {
  if (!declared.empty()) return IndexOf(header, declared);
  for (const std::string& name : usual) {
    if (const int c = IndexOf(header, name); c >= 0) return c;
  }
  return -1;
}

// The column in which most of the names stand; −1: none has any.
int FindTags(const std::vector<std::string>& header,
             const std::vector<std::vector<std::string>>& rows,
             const std::set<std::string>& wanted) {
  int best = -1;
  std::size_t most = 0;
  for (std::size_t c = 0; c < header.size(); ++c) {
    std::set<std::string> found;
    for (const std::vector<std::string>& row : rows) {
      if (c >= row.size()) continue;
      std::string name = FoldedName(row[c]);
      if (wanted.contains(name)) found.insert(std::move(name));
    }
    if (found.size() > most) {
      most = found.size();
      best = static_cast<int>(c);
    }
  }
  return best;
}

// The one column of numbers that is left; −1: none, or several.
int OnlyNumbers(const std::vector<std::string>& header,
                const std::vector<std::vector<std::string>>& rows,
                const LongColumns& columns) {
  int only = -1;
  for (int c = 0; c < static_cast<int>(header.size()); ++c) {
    if (c == columns.time || c == columns.time_part || c == columns.tag ||
        c == columns.quality) {
      continue;
    }
    std::size_t numbers = 0;
    for (const std::vector<std::string>& row : rows) {
      double number = 0.0;
      if (c < static_cast<int>(row.size()) &&
          (ReadCsvNumber(row[c], number) ||
           ReadCsvNumber(row[c], number, ','))) {
        ++numbers;
      }
    }
    if (2 * numbers < rows.size() || numbers == 0) continue;
    if (only >= 0) return -1;
    only = c;
  }
  return only;
}

std::string DeclaredTime(const ColumnOptions& options) {
  return options.time_column == ColumnOptions().time_column
             ? ""
             : options.time_column;
}

// The declared column of qualities, or all that are named as such.
void FindQualities(const std::vector<std::string>& header,
                   const ColumnOptions& options, LongColumns& columns) {
  if (!options.quality_column.empty()) {
    columns.quality = IndexOf(header, options.quality_column);
    return;
  }
  for (int c = 0; c < static_cast<int>(header.size()); ++c) {
    const bool is_quality = FoldedName(header[c]) == "ip_trend_qstatus" ||
                            FoldedName(header[c]) == "q" ||
                            QualityOfName(header[c], {}).has_value();
    if (!is_quality || c == columns.value || c == columns.tag ||
        c == columns.time || c == columns.time_part) {
      continue;
    }
    if (columns.quality < 0) {
      columns.quality = c;
    } else {
      columns.other_qualities.push_back(c);
    }
  }
}

}  // namespace

std::vector<std::string> LongColumnNames(const ColumnOptions& options) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& declared,
                       const std::vector<std::string>& usual) {
    if (!declared.empty()) {
      names.push_back(declared);
    } else {
      names.insert(names.end(), usual.begin(), usual.end());
    }
  };
  add(DeclaredTime(options), UsualTimeColumns());
  add(options.tag_column, UsualTags());
  add(options.value_column, UsualValues());
  return names;
}

absl::StatusOr<std::optional<LongColumns>> FindLongColumns(
    const std::vector<std::string>& header,
    const std::vector<std::vector<std::string>>& rows,
    const std::vector<std::string>& channels, const ColumnOptions& options) {
  for (const auto& [name, option] :
       {std::pair(options.tag_column, "tag_column"),
        std::pair(options.value_column, "value_column"),
        std::pair(options.quality_column, "quality_column")}) {
    if (name.empty() || IndexOf(header, name) >= 0) continue;
    return OptionError(
        option,
        absl::StrCat("there is no column ", QuotedCsvText(name), " (", option,
                     "); the header has ", ListOfNames(header)));
  }
  std::set<std::string> wanted;
  for (const std::string& channel : channels) {
    if (FoldedName(channel) != FoldedName(options.time_column)) {
      wanted.insert(FoldedName(channel));
    }
  }
  for (const std::string& name : header) {
    if (wanted.contains(FoldedName(name))) return std::nullopt;
  }
  LongColumns columns;
  if (const auto parts = SplitTimeName(options.time_column, header)) {
    columns.time = IndexOf(header, parts->first);
    columns.time_part = IndexOf(header, parts->second);
  } else {
    columns.time = Find(header, DeclaredTime(options), UsualTimeColumns());
  }
  const int tags = FindTags(header, rows, wanted);
  columns.tag = !options.tag_column.empty() || tags < 0
                    ? Find(header, options.tag_column, UsualTags())
                    : tags;
  columns.value = Find(header, options.value_column, UsualValues());
  FindQualities(header, options, columns);
  if (columns.value < 0) {
    columns.value = OnlyNumbers(header, rows, columns);
  }
  if (columns.time >= 0 && columns.tag >= 0 && columns.value >= 0) {
    return columns;
  }
  if (tags < 0 && options.tag_column.empty()) return std::nullopt;
  return OptionError(
      "tag_column,value_column,time_column",
      absl::StrCat(
          "this looks like a table with a row for each sample, with "
          "tags in the column ",
          QuotedCsvText(header[columns.tag]),
          "; name all three of its columns: tag_column = ", header[columns.tag],
          ", value_column and time_column. The "
          "header has ",
          ListOfNames(header)));
}

}  // namespace mle
