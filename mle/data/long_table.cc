#include "mle/data/long_table.h"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/nearest_names.h"

namespace mle {
namespace {

const std::vector<std::string>& UsualTimes() {
  static const auto& names =
      *new std::vector<std::string>{"time", "timestamp", "datetime",     "date",
                                    "ts",   "date/time", "ip_trend_time"};
  return names;
}

const std::vector<std::string>& UsualTags() {
  static const auto& names = *new std::vector<std::string>{
      "tag",     "tagname", "tag_name", "tagid",  "point",   "pointname",
      "pointid", "name",    "item",     "signal", "variable"};
  return names;
}

const std::vector<std::string>& UsualValues() {
  static const auto& names =
      *new std::vector<std::string>{"value", "val", "ip_trend_value"};
  return names;
}

const std::vector<std::string>& UsualQualities() {
  static const auto& names = *new std::vector<std::string>{
      "quality", "status", "confidence", "ip_trend_qstatus"};
  return names;
}

// The column of a declared name, or of a usual one; −1: none.
int Find(const std::vector<std::string_view>& header,
         const std::string& declared, const std::vector<std::string>& usual) {
  std::vector<std::string> names = usual;
  if (!declared.empty()) names = {FoldedName(declared)};
  for (std::size_t c = 0; c < header.size(); ++c) {
    const std::string name = FoldedName(header[c]);
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      return static_cast<int>(c);
    }
  }
  return -1;
}

std::string DeclaredTime(const ColumnOptions& options) {
  return options.time_column == ColumnOptions().time_column
             ? ""
             : options.time_column;
}

// A sample of the long table.
struct Entry {
  double time = 0.0;
  int tag = 0;
  int line = 0;
  std::size_t begin = 0;  // in the text: time, value and quality
  int time_size = 0;
  int value_size = 0;
  int quality_size = 0;
};

class Samples {
 public:
  Samples(const LongColumns& columns, const HistorianOptions& options,
          RecordClock clock)
      : columns_(columns), options_(options), clock_(std::move(clock)) {}

  absl::Status Read(CsvRows& rows, const std::vector<std::string>& channels);
  absl::StatusOr<WideTable> Widen(CsvRows& rows);

 private:
  absl::Status Add(const CsvRows& rows,
                   const std::vector<std::string_view>& fields, int tag);
  std::size_t RowEnd(std::size_t begin) const;
  std::string_view Part(const Entry& entry, int from, int size) const {
    return std::string_view(text_).substr(entry.begin + from, size);
  }
  absl::Status AddRow(const CsvRows& rows, std::size_t begin, std::size_t end,
                      WideTable& table, std::vector<int>& lines) const;
  int NumberOf(std::string_view tag, const std::set<std::string>& wanted);

  const LongColumns& columns_;
  const HistorianOptions& options_;
  RecordClock clock_;
  std::string text_;
  std::vector<Entry> entries_;
  std::vector<std::string> tags_;
  std::vector<bool> is_kept_;  // their samples are
};

absl::Status Samples::Add(const CsvRows& rows,
                          const std::vector<std::string_view>& fields,
                          int tag) {
  Entry entry;
  entry.tag = tag;
  entry.line = rows.line();
  entry.begin = text_.size();
  const std::string_view time = TrimCsvField(fields[columns_.time]);
  const std::string_view value = TrimCsvField(fields[columns_.value]);
  const char decimal = options_.decimal == 0 ? '.' : options_.decimal;
  if (!clock_.Read(time, decimal, entry.time) &&
      !(options_.decimal == 0 && clock_.Read(time, ',', entry.time))) {
    return OptionError(
        "time_format",
        absl::StrCat(rows.Place(columns_.time + 1), ": '", ShowCsvText(time),
                     "' is not ", clock_.Wanted(time)));
  }
  entry.time_size = static_cast<int>(time.size());
  entry.value_size = static_cast<int>(value.size());
  text_.append(time).append(value);
  if (columns_.quality >= 0) {
    const std::string_view quality = TrimCsvField(fields[columns_.quality]);
    entry.quality_size = static_cast<int>(quality.size());
    text_.append(quality);
  }
  entries_.push_back(entry);
  return absl::OkStatus();
}

// Of a tag that was not met before; −1: its samples are not kept. Where other
// columns are not to be ignored it is a column without samples, of which the
// header then speaks.
int Samples::NumberOf(std::string_view tag,
                      const std::set<std::string>& wanted) {
  const auto& suffixes = options_.columns.quality_suffixes;
  const bool ignored = options_.columns.ignore_other_columns;
  const bool is_kept =
      wanted.contains(FoldedName(tag)) ||
      (!ignored && std::any_of(suffixes.begin(), suffixes.end(),
                               [tag](const std::string& suffix) {
                                 return tag.ends_with(suffix);
                               }));
  if (!is_kept && ignored) return -1;
  tags_.emplace_back(tag);
  is_kept_.push_back(is_kept);
  return is_kept ? static_cast<int>(tags_.size()) - 1 : -1;
}

absl::Status Samples::Read(CsvRows& rows,
                           const std::vector<std::string>& channels) {
  std::set<std::string> wanted;
  for (const std::string& name : channels) wanted.insert(FoldedName(name));
  std::map<std::string, int, std::less<>> numbers;  // −1: not wanted
  std::vector<std::string_view> fields;
  const auto least = static_cast<std::size_t>(std::max(
      {columns_.time, columns_.tag, columns_.value, columns_.quality}));
  while (rows.Next(fields)) {
    if (fields.size() <= least) {
      return absl::InvalidArgumentError(absl::StrCat(
          rows.Place(static_cast<int>(fields.size())), ": the row ends after ",
          fields.size(), " fields, before its ", least + 1, "th"));
    }
    const std::string_view tag = TrimCsvField(fields[columns_.tag]);
    auto number = numbers.find(tag);
    if (number == numbers.end()) {
      number = numbers.emplace(tag, NumberOf(tag, wanted)).first;
    }
    if (number->second < 0) continue;
    if (static_cast<std::int64_t>(entries_.size()) >=
        4 * options_.max_samples) {
      return absl::InvalidArgumentError(absl::StrCat(
          rows.Place(1), ": a long table of more than ",
          4 * options_.max_samples, " samples; read less at once"));
    }
    MLE_RETURN_IF_ERROR(Add(rows, fields, number->second));
  }
  return rows.status();
}

std::size_t Samples::RowEnd(std::size_t begin) const {
  std::size_t end = begin;
  while (end < entries_.size() && entries_[end].time == entries_[begin].time) {
    ++end;
  }
  return end;
}

absl::Status Samples::AddRow(const CsvRows& rows, std::size_t begin,
                             std::size_t end, WideTable& table,
                             std::vector<int>& lines) const {
  const bool has_quality = columns_.quality >= 0;
  std::vector<const Entry*> cells(tags_.size());
  for (std::size_t e = begin; e < end; ++e) {
    const Entry& entry = entries_[e];
    const Entry*& cell = cells[entry.tag];
    if (cell != nullptr && !options_.skip_repeated_times) {
      return OptionError(
          "skip_repeated_times",
          absl::StrCat(rows.PlaceIn(entry.line, columns_.time + 1), ": '",
                       ShowCsvText(tags_[entry.tag]),
                       "' has a sample at this time in ",
                       rows.LineName(cell->line),
                       " already; such rows are ignored with "
                       "skip_repeated_times = true"));
    }
    if (cell == nullptr) cell = &entry;
  }
  table.text +=
      QuoteCsvField(Part(entries_[begin], 0, entries_[begin].time_size));
  lines.push_back(entries_[begin].line);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const Entry* const cell = cells[c];
    table.text += ',';
    lines.push_back(cell == nullptr ? entries_[begin].line : cell->line);
    if (cell != nullptr) {
      table.text +=
          QuoteCsvField(Part(*cell, cell->time_size, cell->value_size));
    }
    table.is_complete = table.is_complete && (cell != nullptr || !is_kept_[c]);
    if (!has_quality) continue;
    table.text += ',';
    if (cell == nullptr) continue;
    table.text += QuoteCsvField(
        Part(*cell, cell->time_size + cell->value_size, cell->quality_size));
  }
  table.text += '\n';
  return absl::OkStatus();
}

absl::StatusOr<WideTable> Samples::Widen(CsvRows& rows) {
  WideTable table;
  const bool has_quality = columns_.quality >= 0;
  const auto& suffixes = options_.columns.quality_suffixes;
  table.text = QuoteCsvField(options_.columns.time_column);
  for (const std::string& tag : tags_) {
    absl::StrAppend(&table.text, ",", QuoteCsvField(tag));
    if (has_quality) {
      absl::StrAppend(
          &table.text, ",",
          QuoteCsvField(tag + (suffixes.empty() ? "_quality" : suffixes[0])));
    }
  }
  table.text += '\n';
  std::stable_sort(
      entries_.begin(), entries_.end(),
      [](const Entry& a, const Entry& b) { return a.time < b.time; });
  auto lines = std::make_shared<std::vector<int>>();
  for (std::size_t begin = 0; begin < entries_.size();) {
    const std::size_t end = RowEnd(begin);
    MLE_RETURN_IF_ERROR(AddRow(rows, begin, end, table, *lines));
    begin = end;
  }
  const int width = static_cast<int>(tags_.size()) + 1;
  const int header = rows.line() > 0 ? 1 : 0;
  table.origin = [lines, width, has_quality, header, columns = columns_](
                     int line, int field) {
    const int cell = field <= 1 ? 0 : (field - 2) / (has_quality ? 2 : 1) + 1;
    const bool is_quality = has_quality && field > 1 && field % 2 == 1;
    const auto at = static_cast<std::size_t>(line - 2) * width + cell;
    if (line < 2 || at >= lines->size()) return std::pair(header, field);
    return std::pair((*lines)[at], 1 + (cell == 0    ? columns.time
                                        : is_quality ? columns.quality
                                                     : columns.value));
  };
  table.tags = std::move(tags_);
  return table;
}

}  // namespace

const std::vector<std::string>& UsualTimeColumns() { return UsualTimes(); }

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
  add(DeclaredTime(options), UsualTimes());
  add(options.tag_column, UsualTags());
  add(options.value_column, UsualValues());
  return names;
}

std::optional<LongColumns> FindLongColumns(
    const std::vector<std::string_view>& header,
    const std::vector<std::string>& channels, const ColumnOptions& options) {
  for (const std::string& channel : channels) {
    if (FoldedName(channel) == FoldedName(options.time_column)) continue;
    for (const std::string_view name : header) {
      if (FoldedName(name) == FoldedName(channel)) return std::nullopt;
    }
  }
  LongColumns columns;
  columns.time = Find(header, DeclaredTime(options), UsualTimes());
  columns.tag = Find(header, options.tag_column, UsualTags());
  columns.value = Find(header, options.value_column, UsualValues());
  columns.quality = Find(header, options.quality_column, UsualQualities());
  if (columns.time < 0 || columns.tag < 0 || columns.value < 0) {
    return std::nullopt;
  }
  return columns;
}

absl::StatusOr<WideTable> WidenTable(CsvRows& rows, const LongColumns& columns,
                                     const std::vector<std::string>& channels,
                                     const HistorianOptions& options,
                                     RecordClock clock) {
  Samples samples(columns, options, std::move(clock));
  MLE_RETURN_IF_ERROR(samples.Read(rows, channels));
  return samples.Widen(rows);
}

}  // namespace mle
