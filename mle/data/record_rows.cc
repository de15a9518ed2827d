#include "mle/data/record_rows.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/absl_view.h"
#include "mle/base/double_limits.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/nearest_names.h"
#include "mle/data/quality_columns.h"
#include "mle/data/record.h"
#include "mle/data/time_columns.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

constexpr std::size_t kMaxBadQualities = 5;
// Limits of the words that are counted for a message, and shown in it.
constexpr std::size_t kMaxWords = 1000;
constexpr std::size_t kShownWords = 3;
// A quiet NaN whose payload is not that of the processor's own.
constexpr std::uint64_t kNoSample = 0x7FF8'0000'0000'4E53;

// Words of historians and control systems that begin so are bad whatever
// follows: BadNoComm, Bad - Out of Service, [-11059] No Good Data …
bool BeginsAsBad(std::string_view text) {
  return absl::StartsWithIgnoreCase(AbslView(text), "bad") ||
         text.starts_with("[-");
}

bool EqualsIgnoreCase(std::string_view a, std::string_view b) {
  return absl::EqualsIgnoreCase(AbslView(a), AbslView(b));
}

}  // namespace

double NoSample() { return std::bit_cast<double>(kNoSample); }

bool IsNoSample(double value) {
  return std::bit_cast<std::uint64_t>(value) == kNoSample;
}

RecordRows::Vocabulary::Vocabulary(const std::vector<std::string>& list,
                                   bool case_ignored)
    : ignores_case(case_ignored) {
  for (const std::string& text : list) {
    double number = 0.0;
    if (ReadCsvNumber(text, number)) {
      numbers.push_back(number);
    } else {
      texts.push_back(text);
    }
  }
}

bool RecordRows::Vocabulary::Contains(std::string_view text) const {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& word) {
    return ignores_case ? EqualsIgnoreCase(word, text) : word == text;
  });
}

bool RecordRows::Vocabulary::Contains(double number) const {
  return std::find(numbers.begin(), numbers.end(), number) != numbers.end();
}

RecordRows::RecordRows(RowSource& csv, const RecordRowsOptions& options,
                       RecordClock& clock)
    : csv_(&csv),
      clock_(&clock),
      decimal_(options.decimal),
      bad_values_(options.bad_values, false),
      bad_words_(options.bad_words, true),
      any_word_is_bad_(options.any_word_is_bad),
      good_qualities_(options.good_qualities, true),
      has_usual_qualities_(AreUsualQualities(options.good_qualities)),
      word_values_(options.columns.word_values),
      range_(options.range) {}

absl::StatusOr<RecordRows> RecordRows::Open(RowSource& csv,
                                            const ProcessModel& channels,
                                            const RecordRowsOptions& options,
                                            RecordClock& clock) {
  RecordRows rows(csv, options, clock);
  if (!csv.Next(rows.fields_)) {
    MLE_RETURN_IF_ERROR(csv.status());
    return InvalidArgument(csv.source(),
                           ": line 1, column 1: the file is empty; a "
                           "record begins with a header");
  }
  absl::StatusOr<std::vector<RecordColumn>> columns =
      MatchHeader(rows.fields_, channels, options.columns);
  if (!columns.ok()) {
    const bool has_column =
        absl::StartsWith(columns.status().message(), "column");
    return WithPrefix(columns.status(), has_column ? csv.LinePlace() + ", "
                                                   : csv.LinePlace() + ": ");
  }
  rows.columns_ = *std::move(columns);
  rows.num_values_ = 2 * channels.num_outputs() + channels.num_inputs();
  rows.bad_.resize(rows.num_values_);
  for (std::size_t c = 0; c < rows.columns_.size(); ++c) {
    const RecordColumn& column = rows.columns_[c];
    rows.value_of_.push_back(ValueOf(column, channels));
    if (column.kind == Kind::kTime) rows.time_column_ = static_cast<int>(c);
    if (column.kind == Kind::kTimePart) rows.time_part_ = static_cast<int>(c);
    if (column.kind == Kind::kQuality) rows.has_quality_ = true;
  }
  for (int r = 0; r < options.rows_below_header; ++r) {
    if (!csv.SkipLine()) break;
  }
  csv.set_skips_comments();
  return rows;
}

std::string RecordRows::TimePlaceOf(int line) const {
  return absl::StrCat(csv_->PlaceIn(line, time_column_ + 1), " ('",
                      ShowCsvText(columns_[time_column_].name), "')");
}

bool RecordRows::NotReadable(std::size_t c, std::string_view wanted) {
  const char* const options =
      columns_[c].kind == Kind::kTime ? "time_format" : "bad_values";
  status_ =
      OptionError(options, absl::StrCat(csv_->Place(static_cast<int>(c) + 1),
                                        " ('", ShowCsvText(columns_[c].name),
                                        "'): '", ShowCsvText(fields_[c]),
                                        "' is not ", std::string(wanted)));
  return false;
}

// A sample; NaN for a bad one. False for text that is neither.
bool RecordRows::ReadSample(std::string_view field, double& sample,
                            BadSampleCounts& bad) const {
  const std::string_view text = TrimCsvField(field);
  // Numbers first: they are what there is most of.
  if (!text.empty() && ReadCsvNumber(text, sample, decimal_)) {
    if (std::isnan(sample)) {
      ++bad.not_a_number;
      return true;
    }
    const bool is_bad =
        (!bad_values_.numbers.empty() && bad_values_.Contains(sample)) ||
        (!bad_values_.texts.empty() && bad_values_.Contains(text));
    if (is_bad) {
      ++bad.declared;
      sample = kNaN;
    }
    return is_bad || std::isfinite(sample);
  }
  if (!word_values_.empty() && !text.empty()) {
    const auto word = word_values_.find(FoldedName(text));
    if (word != word_values_.end()) {
      sample = word->second;
      return true;
    }
  }
  sample = kNaN;
  if (text.empty()) {
    sample = NoSample();
    ++bad.empty;
    return true;
  }
  if (!bad_values_.Contains(text) && !bad_words_.Contains(text) &&
      !BeginsAsBad(text) && !any_word_is_bad_) {
    return false;
  }
  ++bad.declared;
  return true;
}

bool RecordRows::IsGood(const RecordColumn& column,
                        std::string_view text) const {
  double number = 0.0;
  // A fault is told by what is not good elsewhere.
  const bool is_listed = column.quality != QualityKind::kFault &&
                         (good_qualities_.Contains(text) ||
                          (ReadCsvNumber(text, number, decimal_) &&
                           good_qualities_.Contains(number)));
  return is_listed ||
         (has_usual_qualities_ && IsUsuallyGood(text, column.quality));
}

// Samples whose quality is not good become NaN.
void RecordRows::TakeQuality(RecordRow& row) {
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].kind != Kind::kQuality) continue;
    const std::string_view text = TrimCsvField(fields_[c]);
    if (IsGood(columns_[c], text)) continue;
    const int of = columns_[c].quality_of;
    const int first = of < 0 ? 0 : value_of_[of];
    const int last = of < 0 ? num_values_ - 1 : first;
    for (int value = first; value <= last; ++value) {
      if (std::isnan(row.values[value])) continue;
      ++bad_[value].quality;
      row.values[value] = kNaN;
    }
    if (of >= 0) row.values[first] = kNaN;
    if (bad_qualities_.size() < kMaxBadQualities) {
      std::string shown = ShowCsvText(text);
      if (std::find(bad_qualities_.begin(), bad_qualities_.end(), shown) ==
          bad_qualities_.end()) {
        bad_qualities_.push_back(std::move(shown));
      }
    }
  }
}

// Words that are not known, from the present row to the end of the file: how
// many there are and the most frequent.
std::string RecordRows::UnknownWords() {
  std::map<std::string, std::int64_t> counts;
  std::int64_t total = 0;
  BadSampleCounts ignored;
  do {
    for (std::size_t c = 0; c < std::min(fields_.size(), columns_.size());
         ++c) {
      double sample = 0.0;
      if (value_of_[c] < 0 || ReadSample(fields_[c], sample, ignored)) continue;
      ++total;
      std::string word = ShowCsvText(TrimCsvField(fields_[c]));
      if (counts.size() < kMaxWords || counts.contains(word)) {
        ++counts[std::move(word)];
      }
    }
  } while (csv_->Next(fields_));
  std::vector<std::pair<std::string, std::int64_t>> words(counts.begin(),
                                                          counts.end());
  std::stable_sort(
      words.begin(), words.end(),
      [](const auto& a, const auto& b) { return a.second > b.second; });
  words.resize(std::min(words.size(), kShownWords));
  return absl::StrCat(
      total, total == 1 ? " sample is" : " samples are", " like this, ",
      counts.size() > words.size() ? "most often " : "",
      absl::StrJoin(words, ", ", [](std::string* out, const auto& word) {
        absl::StrAppend(out, "'", word.first, "' (", word.second, ")");
      }));
}

bool RecordRows::NotASample(std::size_t c) {
  const std::string place =
      absl::StrCat(csv_->Place(static_cast<int>(c) + 1), " ('",
                   ShowCsvText(columns_[c].name), "'): '",
                   ShowCsvText(fields_[c]), "' is not ");
  const char* const wanted =
      decimal_ == '.' ? "a finite number, or empty or NaN for a bad sample"
                      : "a finite number with a decimal comma, or empty "
                        "or NaN for a bad sample";
  status_ = OptionError(
      "bad_values,any_word_is_bad",
      absl::StrCat(place, wanted, "; ", UnknownWords(),
                   ". Name those that mean bad in bad_values, or take all for "
                   "bad with any_word_is_bad = true"));
  return false;
}

bool RecordRows::Next(RecordRow& row) {
  while (status_.ok()) {
    if (!csv_->Next(fields_)) {
      status_ = csv_->status();
      return false;
    }
    if (fields_.size() != columns_.size()) {
      status_ = OptionError(
          "separator",
          absl::StrCat(csv_->Place(static_cast<int>(fields_.size())),
                       ": the row ends after ", fields_.size(),
                       " fields, the header has ", columns_.size(),
                       "; fields that hold a separator must be quoted, or "
                       "another one be declared (separator)"));
      return false;
    }
    if (IsHeader()) {
      ++repeated_headers_;
      continue;
    }
    if (!ReadTime(row)) return false;
    if (range_.Contains(row.time, *clock_)) return ReadSamples(row);
    ++passed_over_;
  }
  return false;
}

// The header once more: as samples are, its names are not numbers.
bool RecordRows::IsHeader() const {
  const std::string_view field = TrimCsvField(fields_[time_column_]);
  if (field.empty() || field != columns_[time_column_].name) return false;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (value_of_[c] >= 0 && TrimCsvField(fields_[c]) != columns_[c].name) {
      return false;
    }
  }
  return true;
}

std::string_view RecordRows::TimeText() {
  if (time_part_ < 0) return fields_[time_column_];
  joined_time_ = JoinTimeFields(fields_[time_column_], fields_[time_part_]);
  return joined_time_;
}

bool RecordRows::ReadTime(RecordRow& row) {
  const std::string_view text = TimeText();
  if (!clock_->Read(text, decimal_, row.time)) {
    fields_[time_column_] = text;
    return NotReadable(time_column_, clock_->Wanted(text));
  }
  status_ = range_.Fits(*clock_);
  return status_.ok();
}

bool RecordRows::ReadSamples(RecordRow& row) {
  row.values.assign(num_values_, NoSample());
  bool is_large = false;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const RecordColumn& column = columns_[c];
    const int value = value_of_[c];
    if (value < 0) continue;
    double sample = kNaN;
    if (!ReadSample(fields_[c], sample, bad_[value])) return NotASample(c);
    const bool has_unit = column.scale != 1.0 || column.offset != 0.0;
    if (has_unit && !std::isnan(sample)) {
      sample = column.scale * sample + column.offset;
      if (std::isinf(sample)) {
        return NotReadable(c, "a finite number once its unit is converted");
      }
    }
    is_large = is_large || std::abs(sample) > kLargestSample;
    row.values[value] = sample;
  }
  if (has_quality_) TakeQuality(row);
  for (std::size_t c = 0; is_large && c < columns_.size(); ++c) {
    if (value_of_[c] >= 0 &&
        std::abs(row.values[value_of_[c]]) > kLargestSample) {
      return NotReadable(c, absl::StrCat("a number of at most ", kLargestSample,
                                         "; is its unit right, or is it bad?"));
    }
  }
  return true;
}

}  // namespace mle
