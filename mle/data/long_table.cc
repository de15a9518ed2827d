#include "mle/data/long_table.h"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/absl_view.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
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

QualityKind KindOf(const std::string& name) {
  const auto quality = QualityOfName(name, {});
  return quality ? quality->kind : QualityKind::kCode;
}

}  // namespace

class WideRows::Samples {
 public:
  Samples(std::vector<std::string> header, LongColumns columns,
          const HistorianOptions& options, RecordClock clock)
      : header_(std::move(header)),
        columns_(std::move(columns)),
        options_(options),
        clock_(std::move(clock)) {}

  absl::Status Read(RowSource& rows, const std::vector<std::string>& channels);
  // The samples in rows, in order of time.
  absl::Status Arrange(const RowSource& rows);

  std::int64_t rows() const { return static_cast<std::int64_t>(rows_.size()); }
  void GetHeader(std::vector<std::string_view>& fields) const;
  void GetRow(std::int64_t row, std::vector<std::string_view>& fields) const;
  // Where a field of a row stands in the long table.
  std::pair<int, int> Origin(int line, int field) const;

  int tags() const { return static_cast<int>(tags_.size()); }
  bool is_complete() const { return is_complete_; }
  std::int64_t repeated_rows() const { return repeated_rows_; }
  std::int64_t comment_rows() const { return comments_; }

 private:
  // A sample of the long table.
  struct Entry {
    double time = 0.0;
    int tag = 0;
    int line = 0;
    std::size_t begin = 0;  // in the text: time, value and quality
    int time_size = 0;
    int value_size = 0;
    int quality_size = 0;
    int repeat = 0;  // of the tag at this time
  };

  absl::Status Add(const RowSource& rows,
                   const std::vector<std::string_view>& fields, int tag);
  std::size_t RowEnd(std::size_t begin) const;
  std::int64_t CountRepeated() const;
  std::string QualitySuffix() const;
  void RepeatRows(std::size_t begin, std::size_t end);
  std::string_view Part(const Entry& entry, int from, int size) const {
    return std::string_view(text_).substr(entry.begin + from, size);
  }
  absl::Status AddRow(const RowSource& rows, std::size_t begin,
                      std::size_t end);
  // By tag: the first of its samples in a row, or null.
  std::vector<const Entry*> CellsOf(std::int64_t row) const;
  int NumberOf(std::string_view tag, const std::set<std::string>& wanted);
  bool IsHeader(const std::vector<std::string_view>& fields) const;

  const std::vector<std::string> header_;
  const LongColumns columns_;
  const HistorianOptions& options_;  // while it reads
  RecordClock clock_;
  std::string text_;
  std::vector<Entry> entries_;
  std::vector<std::pair<std::size_t, std::size_t>> rows_;  // in entries_
  std::vector<std::string> wide_header_;
  std::vector<std::string> tags_;
  std::vector<bool> is_kept_;  // their samples are
  std::int64_t comments_ = 0;
  std::int64_t repeated_rows_ = 0;
  bool is_complete_ = true;
};

// The header once more, as tables written one below the other have it.
bool WideRows::Samples::IsHeader(
    const std::vector<std::string_view>& fields) const {
  for (const int c : {columns_.tag, columns_.value, columns_.time}) {
    if (TrimCsvField(fields[c]) != header_[c]) return false;
  }
  return true;
}

absl::Status WideRows::Samples::Add(const RowSource& rows,
                                    const std::vector<std::string_view>& fields,
                                    int tag) {
  Entry entry;
  entry.tag = tag;
  entry.line = rows.line();
  entry.begin = text_.size();
  std::string joined;
  std::string_view time = TrimCsvField(fields[columns_.time]);
  if (columns_.time_part >= 0) {
    joined = JoinTimeFields(time, fields[columns_.time_part]);
    time = joined;
  }
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
    std::string_view quality = TrimCsvField(fields[columns_.quality]);
    std::string other;
    for (const int c : columns_.other_qualities) {
      const std::string_view text = TrimCsvField(fields[c]);
      if (IsUsuallyGood(text, KindOf(header_[c]))) continue;
      other = absl::StrCat(header_[c], " ", AbslView(text));
      quality = other;
      break;
    }
    entry.quality_size = static_cast<int>(quality.size());
    text_.append(quality);
  }
  entries_.push_back(entry);
  return absl::OkStatus();
}

// Of a tag that was not met before; −1: its samples are not kept. Where other
// columns are not to be ignored it is a column without samples, of which the
// header then speaks.
int WideRows::Samples::NumberOf(std::string_view tag,
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

absl::Status WideRows::Samples::Read(RowSource& rows,
                                     const std::vector<std::string>& channels) {
  std::set<std::string> wanted;
  for (const std::string& name : channels) wanted.insert(FoldedName(name));
  std::map<std::string, int, std::less<>> numbers;  // −1: not wanted
  std::vector<std::string_view> fields;
  const auto least = static_cast<std::size_t>(std::max(
      {columns_.time, columns_.time_part, columns_.tag, columns_.value,
       columns_.quality,
       columns_.other_qualities.empty() ? -1
                                        : columns_.other_qualities.back()}));
  rows.set_skips_comments();
  while (rows.Next(fields)) {
    if (fields.size() <= least) {
      return absl::InvalidArgumentError(absl::StrCat(
          rows.Place(static_cast<int>(fields.size())), ": the row ends after ",
          fields.size(), " fields, before its ", least + 1, "th"));
    }
    if (IsHeader(fields)) {
      ++comments_;
      continue;
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
  comments_ += rows.comments();
  return rows.status();
}

std::size_t WideRows::Samples::RowEnd(std::size_t begin) const {
  std::size_t end = begin;
  while (end < entries_.size() && entries_[end].time == entries_[begin].time) {
    ++end;
  }
  return end;
}

// Samples of a tag at a time at which it has one already.
std::int64_t WideRows::Samples::CountRepeated() const {
  std::int64_t repeated = 0;
  std::set<int> tags;
  for (std::size_t e = 0; e < entries_.size(); ++e) {
    if (e == 0 || entries_[e].time != entries_[e - 1].time) tags.clear();
    if (!tags.insert(entries_[e].tag).second) ++repeated;
  }
  return repeated;
}

// Samples of one time: the first of each tag, then the second of each.
void WideRows::Samples::RepeatRows(std::size_t begin, std::size_t end) {
  std::vector<int> counts(tags_.size(), 0);
  for (std::size_t e = begin; e < end; ++e) {
    entries_[e].repeat = counts[entries_[e].tag]++;
  }
  std::stable_sort(
      entries_.begin() + static_cast<std::ptrdiff_t>(begin),
      entries_.begin() + static_cast<std::ptrdiff_t>(end),
      [](const Entry& a, const Entry& b) { return a.repeat < b.repeat; });
}

absl::Status WideRows::Samples::AddRow(const RowSource& rows, std::size_t begin,
                                       std::size_t end) {
  std::vector<const Entry*> cells(tags_.size());
  for (std::size_t e = begin; e < end; ++e) {
    const Entry& entry = entries_[e];
    const Entry*& cell = cells[entry.tag];
    if (cell != nullptr && !options_.skip_repeated_times) {
      return OptionError(
          "skip_repeated_times,spread_repeated_times",
          absl::StrCat(
              rows.PlaceIn(entry.line, columns_.time + 1), ": '",
              ShowCsvText(tags_[entry.tag]), "' has a sample at this time in ",
              rows.LineName(cell->line), " already, one of ", CountRepeated(),
              " such rows; such rows are ignored with "
              "skip_repeated_times = true, or, if seconds were lost, "
              "spread evenly with spread_repeated_times = true"));
    }
    if (cell != nullptr) ++repeated_rows_;
    if (cell == nullptr) cell = &entry;
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    is_complete_ = is_complete_ && (cells[c] != nullptr || !is_kept_[c]);
  }
  rows_.emplace_back(begin, end);
  return absl::OkStatus();
}

// By which the wide table tells of what kind its qualities are.
std::string WideRows::Samples::QualitySuffix() const {
  const auto& suffixes = options_.columns.quality_suffixes;
  if (columns_.quality >= 0 && AreUsualSuffixes(suffixes)) {
    return "_" + UsualQualityName(KindOf(header_[columns_.quality]));
  }
  return suffixes.empty() ? "_quality" : suffixes[0];
}

absl::Status WideRows::Samples::Arrange(const RowSource& rows) {
  const std::string suffix = QualitySuffix();
  wide_header_ = {options_.columns.time_column};
  for (const std::string& tag : tags_) {
    wide_header_.push_back(tag);
    if (columns_.quality >= 0) wide_header_.push_back(tag + suffix);
  }
  std::stable_sort(
      entries_.begin(), entries_.end(),
      [](const Entry& a, const Entry& b) { return a.time < b.time; });
  for (std::size_t begin = 0; begin < entries_.size();) {
    const std::size_t end = RowEnd(begin);
    if (options_.spread_repeated_times) RepeatRows(begin, end);
    for (std::size_t from = begin; from < end;) {
      std::size_t to = from + 1;
      while (to < end && (!options_.spread_repeated_times ||
                          entries_[to].repeat == entries_[from].repeat)) {
        ++to;
      }
      MLE_RETURN_IF_ERROR(AddRow(rows, from, to));
      from = to;
    }
    begin = end;
  }
  return absl::OkStatus();
}

std::vector<const WideRows::Samples::Entry*> WideRows::Samples::CellsOf(
    std::int64_t row) const {
  std::vector<const Entry*> cells(tags_.size());
  const auto& [begin, end] = rows_[static_cast<std::size_t>(row)];
  for (std::size_t e = begin; e < end; ++e) {
    const Entry*& cell = cells[entries_[e].tag];
    if (cell == nullptr) cell = &entries_[e];
  }
  return cells;
}

void WideRows::Samples::GetHeader(std::vector<std::string_view>& fields) const {
  fields.assign(wide_header_.begin(), wide_header_.end());
}

void WideRows::Samples::GetRow(std::int64_t row,
                               std::vector<std::string_view>& fields) const {
  const Entry& first = entries_[rows_[static_cast<std::size_t>(row)].first];
  fields.assign({Part(first, 0, first.time_size)});
  for (const Entry* const cell : CellsOf(row)) {
    fields.push_back(cell == nullptr
                         ? std::string_view()
                         : Part(*cell, cell->time_size, cell->value_size));
    if (columns_.quality < 0) continue;
    fields.push_back(cell == nullptr
                         ? std::string_view()
                         : Part(*cell, cell->time_size + cell->value_size,
                                cell->quality_size));
  }
}

std::pair<int, int> WideRows::Samples::Origin(int line, int field) const {
  if (line < 2 || line - 2 >= rows()) return {1, field};
  const int width = columns_.quality >= 0 ? 2 : 1;  // of a tag
  const Entry* entry =
      &entries_[rows_[static_cast<std::size_t>(line - 2)].first];
  if (field <= 1) return {entry->line, 1 + columns_.time};
  const int tag = (field - 2) / width;
  if (tag >= tags()) return {1, field};
  const Entry* const cell = CellsOf(line - 2)[static_cast<std::size_t>(tag)];
  if (cell != nullptr) entry = cell;
  return {entry->line,
          1 + ((field - 2) % width > 0 ? columns_.quality : columns_.value)};
}

absl::StatusOr<std::unique_ptr<WideRows>> WideRows::Read(
    RowSource& rows, const std::vector<std::string>& header,
    const LongColumns& columns, const std::vector<std::string>& channels,
    const HistorianOptions& options, RecordClock clock) {
  const auto samples =
      std::make_shared<Samples>(header, columns, options, std::move(clock));
  MLE_RETURN_IF_ERROR(samples->Read(rows, channels));
  MLE_RETURN_IF_ERROR(samples->Arrange(rows));
  return std::unique_ptr<WideRows>(
      new WideRows(samples, rows.source(), rows.is_table()));
}

bool WideRows::Next(std::vector<std::string_view>& fields) {
  if (at_ > samples_->rows()) return false;
  if (at_ == 0) {
    samples_->GetHeader(fields);
  } else {
    samples_->GetRow(at_ - 1, fields);
  }
  row_line_ = static_cast<int>(++at_);
  return true;
}

std::unique_ptr<RowSource> WideRows::Preview() {
  std::unique_ptr<WideRows> rows(new WideRows(samples_, source(), is_table()));
  rows->at_ = at_;
  return rows;
}

std::pair<int, int> WideRows::Origin(int line, int field) const {
  return samples_->Origin(line, field);
}

std::int64_t WideRows::rows() const { return samples_->rows(); }
int WideRows::tags() const { return samples_->tags(); }
bool WideRows::is_complete() const { return samples_->is_complete(); }
std::int64_t WideRows::repeated_rows() const {
  return samples_->repeated_rows();
}
std::int64_t WideRows::comment_rows() const { return samples_->comment_rows(); }

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
