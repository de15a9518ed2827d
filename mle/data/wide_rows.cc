#include "mle/data/wide_rows.h"

#include <algorithm>
#include <map>
#include <set>

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

  void GetHeader(std::vector<std::string_view>& fields) const;
  void GetRow(std::int64_t row, std::vector<std::string_view>& fields) const;
  // Where a field of a row stands in the long table.
  std::pair<int, int> Origin(int line, int field) const;

  const WideCounts& counts() const { return counts_; }

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
  // `cells` is memory, by tag.
  absl::Status AddRow(const RowSource& rows, std::size_t begin, std::size_t end,
                      std::vector<const Entry*>& cells);
  int width() const { return columns_.quality >= 0 ? 2 : 1; }  // of a tag
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
  WideCounts counts_;
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

// The number of a tag that was not met before; −1: its samples are not kept.
// Unless other columns are ignored, such a tag is a column without samples, so
// that the header names it.
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
      return InvalidArgument(rows.Place(static_cast<int>(fields.size())),
                             ": the row ends after ", fields.size(),
                             " fields, it needs ", least + 1);
    }
    if (IsHeader(fields)) {
      ++counts_.comment_rows;
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
      return InvalidArgument(rows.Place(1), ": a long table of more than ",
                             4 * options_.max_samples,
                             " samples; read less at once");
    }
    MLE_RETURN_IF_ERROR(Add(rows, fields, number->second));
  }
  counts_.comment_rows += rows.comments();
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
                                       std::size_t end,
                                       std::vector<const Entry*>& cells) {
  cells.assign(tags_.size(), nullptr);
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
    if (cell != nullptr) ++counts_.repeated_rows;
    if (cell == nullptr) cell = &entry;
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    counts_.is_complete &= cells[c] != nullptr || !is_kept_[c];
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
  std::vector<const Entry*> cells;
  for (std::size_t begin = 0; begin < entries_.size();) {
    const std::size_t end = RowEnd(begin);
    if (options_.spread_repeated_times) RepeatRows(begin, end);
    for (std::size_t from = begin; from < end;) {
      std::size_t to = from + 1;
      while (to < end && (!options_.spread_repeated_times ||
                          entries_[to].repeat == entries_[from].repeat)) {
        ++to;
      }
      MLE_RETURN_IF_ERROR(AddRow(rows, from, to, cells));
      from = to;
    }
    begin = end;
  }
  counts_.tags = static_cast<int>(tags_.size());
  counts_.rows = static_cast<std::int64_t>(rows_.size());
  return absl::OkStatus();
}

void WideRows::Samples::GetHeader(std::vector<std::string_view>& fields) const {
  fields.assign(wide_header_.begin(), wide_header_.end());
}

// Of several samples of a tag in a row the first counts.
void WideRows::Samples::GetRow(std::int64_t row,
                               std::vector<std::string_view>& fields) const {
  const auto& [begin, end] = rows_[static_cast<std::size_t>(row)];
  fields.assign(wide_header_.size(), std::string_view());
  fields[0] = Part(entries_[begin], 0, entries_[begin].time_size);
  for (std::size_t e = begin; e < end; ++e) {
    const Entry& entry = entries_[e];
    const auto at = static_cast<std::size_t>(1 + width() * entry.tag);
    if (fields[at].data() != nullptr) continue;
    fields[at] = Part(entry, entry.time_size, entry.value_size);
    if (columns_.quality < 0) continue;
    fields[at + 1] =
        Part(entry, entry.time_size + entry.value_size, entry.quality_size);
  }
}

std::pair<int, int> WideRows::Samples::Origin(int line, int field) const {
  if (line < 2 || line - 2 >= counts_.rows) return {1, field};
  const auto& [begin, end] = rows_[static_cast<std::size_t>(line - 2)];
  const int first = entries_[begin].line;
  if (field <= 1) return {first, 1 + columns_.time};
  const int tag = (field - 2) / width();
  if (tag >= counts_.tags) return {1, field};
  const int column =
      1 + ((field - 2) % width() > 0 ? columns_.quality : columns_.value);
  for (std::size_t e = begin; e < end; ++e) {
    if (entries_[e].tag == tag) return {entries_[e].line, column};
  }
  return {first, column};
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
  if (at_ > samples_->counts().rows) return false;
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

const WideCounts& WideRows::counts() const { return samples_->counts(); }

}  // namespace mle
