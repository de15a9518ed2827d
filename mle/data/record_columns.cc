#include "mle/data/record_columns.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/nearest_names.h"
#include "mle/data/time_columns.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;
using ColumnsByName = std::map<std::string, RecordColumn, std::less<>>;

constexpr std::string_view kSetPointSuffix = "_setpoint";

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
      column.is_mapped = true;
      column.scale = found->second->scale;
      column.offset = found->second->offset;
    }
    if (!columns.emplace(column.name, column).second) {
      return InvalidArgument("a column ", QuotedCsvText(column.name),
                             " would be two channels; map the tags otherwise");
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
    if (kind == Kind::kOther || kind == Kind::kTime ||
        kind == Kind::kTimePart) {
      continue;
    }
    samples[columns[c].name] = static_cast<int>(c);
  }
  std::vector<std::string_view> names;
  for (const auto& [name, column] : samples) names.push_back(name);
  const auto& unused = options.unused_tags;
  for (RecordColumn& column : columns) {
    if (column.kind != Kind::kOther ||
        std::find(unused.begin(), unused.end(), column.name) != unused.end()) {
      continue;
    }
    for (const std::string& suffix : options.quality_suffixes) {
      if (suffix.empty() || !column.name.ends_with(suffix)) continue;
      const auto found =
          samples.find(std::string_view(column.name)
                           .substr(0, column.name.size() - suffix.size()));
      if (found == samples.end()) continue;
      column.kind = Kind::kQuality;
      column.quality_of = found->second;
    }
    if (column.kind == Kind::kQuality ||
        !AreUsualSuffixes(options.quality_suffixes)) {
      continue;
    }
    const auto quality = QualityOfName(column.name, names);
    // A status alone may be that of the plant.
    if (!quality ||
        (quality->column.empty() &&
         (quality->kind == QualityKind::kCode ||
          quality->kind == QualityKind::kConfidence) &&
         FoldedName(column.name).find("quality") == std::string::npos)) {
      continue;
    }
    column.kind = Kind::kQuality;
    column.quality = quality->kind;
    column.quality_of =
        quality->column.empty() ? -1 : samples.find(quality->column)->second;
  }
}

constexpr std::size_t kShownColumnFaults = 6;

// A header as it is matched.
class Matching {
 public:
  Matching(ColumnsByName wanted, const ColumnOptions& options)
      : wanted_(std::move(wanted)), options_(options) {}

  void Match(const std::vector<std::string_view>& header);
  absl::Status Check();
  std::vector<RecordColumn>& columns() { return columns_; }

 private:
  void SplitTime(const std::vector<std::string_view>& header);
  void Take(ColumnsByName::iterator found, std::size_t column);
  void MatchFolded();
  void MatchUsualTime();
  std::string Describe(const std::string& wanted,
                       const std::vector<std::string>& near) const;
  void FindMissing(std::vector<std::string>& faults);
  std::string OnSetPoints() const;
  bool IsIgnored(const std::string& name) const;
  bool IsUnused(const std::string& name) const;
  void FindOthers(std::vector<std::string>& faults) const;
  std::string SuffixAdvice(const std::vector<std::string>& others) const;

  ColumnsByName wanted_;  // those not found yet
  const ColumnOptions& options_;
  std::vector<RecordColumn> columns_;
  std::vector<std::string> repeated_;
  std::vector<std::string> names_;  // as they stand
  std::set<std::string> meant_;     // may be what a missing column is
  bool is_missing_ = false;         // a column that is needed
};

void Matching::Take(ColumnsByName::iterator found, std::size_t column) {
  const std::string name = columns_[column].name;
  columns_[column] = std::move(found->second);
  columns_[column].name = name;
  wanted_.erase(found);
}

// A time that is named as two columns.
void Matching::SplitTime(const std::vector<std::string_view>& header) {
  const auto time = wanted_.find(options_.time_column);
  if (time == wanted_.end() || time->second.kind != Kind::kTime) return;
  const auto parts = SplitTimeName(time->first, {header.begin(), header.end()});
  if (!parts || wanted_.contains(parts->first) ||
      wanted_.contains(parts->second) || parts->first == parts->second) {
    return;
  }
  RecordColumn column = time->second;
  wanted_.erase(time);
  column.name = parts->first;
  wanted_.emplace(column.name, column);
  column.kind = Kind::kTimePart;
  column.name = parts->second;
  wanted_.emplace(column.name, column);
}

void Matching::Match(const std::vector<std::string_view>& header) {
  SplitTime(header);
  std::set<std::string> seen;
  for (std::size_t c = 0; c < header.size(); ++c) {
    const bool is_exact = wanted_.find(header[c]) != wanted_.end();
    const std::string name(is_exact ? header[c]
                           : c == 0 ? WithoutHash(header[c])
                                    : TrimCsvField(header[c]));
    columns_.emplace_back().name = name;
    names_.push_back(name);
    if (!seen.insert(name).second &&
        !(name.empty() && options_.ignore_other_columns)) {
      repeated_.push_back(absl::StrCat("column ", c + 1, ": ",
                                       QuotedCsvText(name), " is duplicated"));
      continue;
    }
    const auto found = wanted_.find(name);
    if (found != wanted_.end()) Take(found, c);
  }
  MatchFolded();
  MatchUsualTime();
  MatchQuality(options_, columns_);
}

// Names that differ in case and blanks, of which there is one on each side.
void Matching::MatchFolded() {
  std::map<std::string, std::vector<std::size_t>> columns;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].kind != Kind::kOther) continue;
    columns[FoldedName(columns_[c].name)].push_back(c);
  }
  std::map<std::string, std::vector<std::string>> wanted;
  for (const auto& [name, column] : wanted_) {
    wanted[FoldedName(name)].push_back(name);
  }
  for (const auto& [folded, names] : wanted) {
    const auto found = columns.find(folded);
    if (found == columns.end() || names.size() > 1 ||
        found->second.size() > 1) {
      continue;
    }
    Take(wanted_.find(names[0]), found->second[0]);
  }
}

// Where no name of the column of times is declared, and one is usual.
void Matching::MatchUsualTime() {
  const auto time = wanted_.find(ColumnOptions().time_column);
  if (time == wanted_.end() || time->second.kind != Kind::kTime) return;
  const std::vector<std::string>& usual = UsualTimeColumns();
  std::vector<std::size_t> found;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].kind == Kind::kOther &&
        std::find(usual.begin(), usual.end(), FoldedName(columns_[c].name)) !=
            usual.end()) {
      found.push_back(c);
    }
  }
  if (found.size() == 1) Take(time, found[0]);
}

// A missing column, with where its tag is written and the names that are near.
std::string Matching::Describe(const std::string& wanted,
                               const std::vector<std::string>& near) const {
  std::vector<std::string> remarks;
  for (const TagMapping& tag : options_.tags) {
    if (tag.tag != wanted || tag.place.empty()) continue;
    remarks.push_back(absl::StrCat(ShowCsvText(tag.place), ", for ",
                                   ShowCsvText(tag.channel)));
  }
  if (!near.empty()) {
    remarks.push_back(absl::StrCat("nearest: ", ListOfNames(near)));
  }
  return absl::StrCat(
      QuotedCsvText(wanted),
      remarks.empty() ? ""
                      : absl::StrCat(" (", absl::StrJoin(remarks, "; "), ")"));
}

// A sentence on how to declare set points where no column is one; it names the
// columns without a use whose tags look like set points.
std::string Matching::OnSetPoints() const {
  std::vector<std::string> likely;
  for (const RecordColumn& column : columns_) {
    if (column.kind == Kind::kSetPoint) return "";
    if (column.kind == Kind::kOther && IsSetPointTag(column.name)) {
      likely.push_back(column.name);
    }
  }
  for (const auto& [name, column] : wanted_) {
    if (column.kind == Kind::kSetPoint && column.is_mapped) return "";
  }
  return absl::StrCat(
      "No column is named as a set point, <output>_setpoint: ",
      likely.empty()
          ? "map one, or give change_times"
          : absl::StrCat("map those there are (perhaps ", ListOfNames(likely),
                         "), or give change_times"));
}

void Matching::FindMissing(std::vector<std::string>& faults) {
  std::vector<std::string> missing;
  std::vector<std::string> free;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].kind == Kind::kOther) free.push_back(columns_[c].name);
  }
  for (const auto& [name, column] : wanted_) {
    if (column.kind == Kind::kSetPoint && !column.is_mapped) continue;
    const std::vector<std::string> near = NearestNames(name, free);
    meant_.insert(near.begin(), near.end());
    missing.push_back(Describe(name, near));
  }
  if (missing.empty()) return;
  is_missing_ = true;
  if (missing.size() > kShownNames) {
    missing.resize(kShownNames);
    missing.emplace_back("…");
  }
  faults.push_back(absl::StrCat(
      "there is no column ", absl::StrJoin(missing, ", "),
      "; the header must name time and every input and output (time_column, "
      "tags), and has ",
      ListOfNames(names_)));
  if (free.size() == columns_.size()) {
    faults.emplace_back(
        "None of these is known: this may not be a table of records, or lines "
        "stand above its header (lines_above_header)");
  }
  if (std::string text = OnSetPoints(); !text.empty()) {
    faults.push_back(std::move(text));
  }
}

bool Matching::IsIgnored(const std::string& name) const {
  return options_.ignore_other_columns || meant_.contains(name);
}

bool Matching::IsUnused(const std::string& name) const {
  return std::find(options_.unused_tags.begin(), options_.unused_tags.end(),
                   name) != options_.unused_tags.end();
}

void Matching::FindOthers(std::vector<std::string>& faults) const {
  std::vector<std::string> others;
  std::size_t first = 0;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const std::string& name = columns_[c].name;
    if (columns_[c].kind != Kind::kOther) continue;
    if (IsUnused(name)) continue;
    if (IsSetPointName(name)) {
      faults.push_back(absl::StrCat(
          "column ", c + 1, ": ", QuotedCsvText(name),
          " is a set point of an output that the process model does not have"));
    } else if (!IsIgnored(name)) {
      if (others.empty()) first = c + 1;
      others.push_back(name);
    }
  }
  if (others.empty()) return;
  // Where columns are missing, the message has the whole header.
  if (is_missing_) {
    faults.emplace_back(
        "Columns that are not needed are ignored with ignore_other_columns = "
        "true");
    return;
  }
  const std::string rest =
      others.size() == 1
          ? ""
          : absl::StrCat(", nor are ",
                         ListOfNames({others.begin() + 1, others.end()}));
  faults.push_back(absl::StrCat(
      "column ", first, ": ", QuotedCsvText(others[0]),
      " is neither time nor an input, output or set point of the process "
      "model",
      rest, "; other columns are ignored with ignore_other_columns = true",
      SuffixAdvice(others)));
}

// Where a column that is not known stands beside one that is, and has its name
// and more: it may say how good the samples are.
std::string Matching::SuffixAdvice(
    const std::vector<std::string>& others) const {
  for (const std::string& other : others) {
    for (const RecordColumn& column : columns_) {
      if (column.kind == Kind::kOther || column.name.empty() ||
          column.name == other || !other.starts_with(column.name)) {
        continue;
      }
      return absl::StrCat(
          "; if ", QuotedCsvText(other), " says how good samples of ",
          QuotedCsvText(column.name),
          " are: quality_suffixes = ", other.substr(column.name.size()),
          " and good_qualities");
    }
  }
  return "";
}

absl::Status Matching::Check() {
  std::vector<std::string> faults = repeated_;
  FindMissing(faults);
  FindOthers(faults);
  if (faults.empty()) return absl::OkStatus();
  if (faults.size() > kShownColumnFaults) {
    faults.resize(kShownColumnFaults);
    faults.emplace_back("…");
  }
  return OptionError(
      "time_column,tags,lines_above_header,ignore_other_columns,change_times",
      absl::StrJoin(faults, ". "));
}

}  // namespace

bool AreUsualSuffixes(const std::vector<std::string>& suffixes) {
  return suffixes == ColumnOptions().quality_suffixes;
}

std::string SetPointName(std::string_view output) {
  return std::string(output).append(kSetPointSuffix);
}

bool IsSetPointName(std::string_view name) {
  return name.ends_with(kSetPointSuffix);
}

bool IsSetPointTag(std::string_view tag) {
  const std::string folded = FoldedName(tag);
  return folded.ends_with("sp") || folded.ends_with("setpoint") ||
         folded.ends_with("_sv") || folded.ends_with(".sv");
}

namespace {

template <typename Channel>
Sampling DeclaredOf(const Channel& channel,
                    const std::vector<TagMapping>& tags) {
  for (const TagMapping& tag : tags) {
    if (tag.channel == channel.name && tag.sampling) return *tag.sampling;
  }
  return channel.sampling;
}

}  // namespace

Sampling SamplingOf(const OutputChannel& output,
                    const std::vector<TagMapping>& tags) {
  return DeclaredOf(output, tags);
}

Sampling SamplingOf(const InputChannel& input,
                    const std::vector<TagMapping>& tags) {
  return DeclaredOf(input, tags);
}

absl::Status ColumnOptions::Validate(const ProcessModel& channels) const {
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> known,
                       ColumnsOf(channels));
  std::set<std::string> free;
  for (const RecordColumn& column : known) {
    if (column.kind != Kind::kTime) free.insert(column.name);
  }
  for (const TagMapping& tag : tags) {
    const std::string place = absl::StrCat("tag ", QuotedCsvText(tag.tag),
                                           " for ", QuotedCsvText(tag.channel));
    if (free.erase(tag.channel) == 0) {
      return InvalidArgument(place,
                             ": the process model has no such input, output or "
                             "<output>_setpoint, or it is mapped twice");
    }
    if (tag.tag.empty()) {
      return InvalidArgument(place, ": a tag needs a name");
    }
    if (!std::isfinite(tag.scale) || tag.scale == 0.0 ||
        !std::isfinite(tag.offset)) {
      return InvalidArgument(place, ": scale is ", tag.scale, " and offset ",
                             tag.offset,
                             "; both must be finite, the scale not 0");
    }
  }
  return absl::OkStatus();
}

std::vector<std::string> ChannelNames(const ProcessModel& channels) {
  std::vector<std::string> names;
  for (const OutputChannel& output : channels.outputs()) {
    names.push_back(output.name);
    names.push_back(SetPointName(output.name));
  }
  for (const InputChannel& input : channels.inputs()) {
    names.push_back(input.name);
  }
  return names;
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
    return InvalidArgument(
        "the process model has a channel '", column.name,
        "', which in a record is the name of another column (time, or the set "
        "point of an output); rename the channel");
  }
  return columns;
}

absl::StatusOr<std::vector<RecordColumn>> MatchHeader(
    const std::vector<std::string_view>& header, const ProcessModel& channels,
    const ColumnOptions& options) {
  MLE_ASSIGN_OR_RETURN(ColumnsByName wanted, NameColumns(channels, options));
  Matching matching(std::move(wanted), options);
  matching.Match(header);
  MLE_RETURN_IF_ERROR(matching.Check());
  return std::move(matching.columns());
}

}  // namespace mle
