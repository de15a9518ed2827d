#include "mle/data/tag_file.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/historian_file.h"
#include "mle/data/joined_files.h"
#include "mle/data/nearest_names.h"

namespace mle {
namespace {

constexpr std::size_t kShownTagFaults = 20;
enum Field {
  kTag,
  kChannel,
  kScale,
  kOffset,
  kUnit,
  kFoundUnit,
  kPeriod,
  kHeld,
  kLateBy,
  kAverage,
  kStamp,
  kNumFields
};
constexpr std::array<std::string_view, kNumFields> kFieldNames = {
    "tag",    "channel", "scale",   "offset",  "unit", "unitinthefile",
    "period", "held",    "late_by", "average", "stamp"};

// Channels by name, with their units.
std::map<std::string, std::string> UnitsOf(const ProcessModel& channels) {
  std::map<std::string, std::string> units;
  for (const OutputChannel& output : channels.outputs()) {
    units[output.name] = output.unit;
    units[SetPointName(output.name)] = output.unit;
  }
  for (const InputChannel& input : channels.inputs()) {
    units[input.name] = input.unit;
  }
  return units;
}

class TagFile {
 public:
  TagFile(const std::string& source, const ProcessModel& channels)
      : source_(source), units_(UnitsOf(channels)) {
    columns_.fill(-1);
    for (const auto& [name, unit] : units_) names_.push_back(name);
    for (const InputChannel& input : channels.inputs()) {
      inputs_.insert(input.name);
    }
  }

  absl::StatusOr<TagTable> Parse(const std::string& text);

 private:
  absl::Status ParseHeader(CsvRows& rows);
  void ParseRow(const CsvRows& rows);
  std::string_view At(Field field) const;
  double Number(Field field, double otherwise);
  std::optional<Sampling> DeclaredSampling(const std::string& channel);
  void Fault(const std::string& what) {
    faults_.push_back(absl::StrCat("line ", line_, ": ", what));
  }

  const std::string& source_;
  std::map<std::string, std::string> units_;
  std::vector<std::string> names_;
  std::set<std::string> inputs_;
  std::array<int, kNumFields> columns_;
  std::vector<std::string_view> fields_;
  int line_ = 0;
  std::map<std::string, int> tags_;  // and the line of each
  std::map<std::string, int> mapped_;
  TagTable table_;
  std::vector<std::string> faults_;
};

std::string_view TagFile::At(Field field) const {
  const int column = columns_[field];
  if (column < 0 || column >= static_cast<int>(fields_.size())) return {};
  return TrimCsvField(fields_[column]);
}

double TagFile::Number(Field field, double otherwise) {
  const std::string_view text = At(field);
  double number = otherwise;
  if (text.empty()) return number;
  if (!ReadCsvNumber(text, number) || !std::isfinite(number)) {
    Fault(absl::StrCat(std::string(kFieldNames[field]), " is ",
                       QuotedCsvText(text),
                       ", must be a number with a decimal point, or empty"));
    return otherwise;
  }
  return number;
}

// What the fields of a row declare; none where all are empty.
std::optional<Sampling> TagFile::DeclaredSampling(const std::string& channel) {
  bool is_declared = false;
  for (const Field field : {kPeriod, kHeld, kLateBy, kAverage, kStamp}) {
    is_declared = is_declared || !At(field).empty();
  }
  if (!is_declared) return std::nullopt;
  Sampling sampling;
  sampling.period = Number(kPeriod, 0.0);
  sampling.late_by = Number(kLateBy, 0.0);
  sampling.average = Number(kAverage, 0.0);
  const std::string held = FoldedName(At(kHeld));
  sampling.held = held == "yes" || held == "true" || held == "1";
  if (!sampling.held && !held.empty() && held != "no" && held != "false" &&
      held != "0") {
    Fault(absl::StrCat("held is ", QuotedCsvText(At(kHeld)),
                       ", must be yes, no or empty"));
  }
  const std::string stamp = FoldedName(At(kStamp));
  sampling.stamped_at_end = stamp == "end";
  if (!stamp.empty() && stamp != "start" && stamp != "end") {
    Fault(absl::StrCat("stamp is ", QuotedCsvText(At(kStamp)),
                       ", must be start or end"));
  }
  if (sampling.period < 0.0 || sampling.average < 0.0) {
    Fault("period and average must be greater than 0, or empty");
  }
  if (sampling.held && sampling.period == 0.0) {
    Fault("held needs a period: how often it is measured");
  }
  if ((sampling.average == 0.0) != stamp.empty()) {
    Fault(
        "average, the time that means are over, and stamp (start or end of "
        "it) are needed together");
  }
  if (IsSetPointName(channel) ||
      (inputs_.contains(channel) && sampling.period > 0.0)) {
    Fault(absl::StrCat(QuotedCsvText(channel),
                       IsSetPointName(channel)
                           ? " is a set point: sampling is declared of inputs "
                             "and outputs"
                           : " is an input: period and held are of outputs"));
  }
  return sampling;
}

absl::Status TagFile::ParseHeader(CsvRows& rows) {
  if (!rows.Next(fields_)) {
    MLE_RETURN_IF_ERROR(rows.status());
    return InvalidArgument(source_,
                           ": the file is empty; it begins with "
                           "tag,channel,scale,offset,unit");
  }
  for (std::size_t c = 0; c < fields_.size(); ++c) {
    for (int f = 0; f < kNumFields; ++f) {
      if (FoldedName(fields_[c]) == kFieldNames[f]) {
        columns_[f] = static_cast<int>(c);
      }
    }
  }
  if (columns_[kTag] >= 0 && columns_[kChannel] >= 0) return absl::OkStatus();
  return InvalidArgument(
      source_, ": line ", rows.line(),
      ": the header must name tag and channel, and may name scale, offset, "
      "unit, period, held, late_by, average and stamp, separated by commas");
}

void TagFile::ParseRow(const CsvRows& rows) {
  line_ = rows.line();
  TagMapping mapping;
  mapping.tag = std::string(At(kTag));
  mapping.channel = std::string(At(kChannel));
  mapping.scale = Number(kScale, 1.0);
  mapping.offset = Number(kOffset, 0.0);
  mapping.place = absl::StrCat(source_, ", line ", line_);
  if (mapping.channel.empty()) {
    if (!mapping.tag.empty()) table_.unused.push_back(mapping.tag);
    return;
  }
  if (mapping.tag.empty()) Fault("a channel without a tag");
  if (mapping.scale == 0.0) Fault("scale is 0");
  if (!tags_.emplace(mapping.tag, line_).second) {
    Fault(absl::StrCat("the tag ", QuotedCsvText(mapping.tag),
                       " stands in line ", tags_[mapping.tag], " too"));
  }
  const auto found = units_.find(mapping.channel);
  if (found == units_.end()) {
    const std::vector<std::string> near = NearestNames(mapping.channel, names_);
    Fault(absl::StrCat(
        QuotedCsvText(mapping.channel),
        " is not an input, output or <output>_setpoint of the model",
        near.empty() ? "; the model has " : "; nearest: ",
        ListOfNames(near.empty() ? names_ : near)));
    return;
  }
  if (!mapped_.emplace(mapping.channel, line_).second) {
    Fault(absl::StrCat("the channel ", QuotedCsvText(mapping.channel),
                       " stands in line ", mapped_[mapping.channel], " too"));
  }
  mapping.sampling = DeclaredSampling(mapping.channel);
  const std::string_view unit = At(kUnit);
  if (!unit.empty() && FoldedName(unit) != FoldedName(found->second)) {
    Fault(absl::StrCat("the unit of ", QuotedCsvText(mapping.tag),
                       " after its conversion is ", QuotedCsvText(unit),
                       ", the model's of ", QuotedCsvText(mapping.channel), " ",
                       QuotedCsvText(found->second),
                       "; scale and offset convert it"));
  }
  const std::string_view other = At(kFoundUnit);
  if (mapping.scale == 1.0 && mapping.offset == 0.0 && !other.empty() &&
      !unit.empty() && FoldedName(other) != FoldedName(unit)) {
    Fault(absl::StrCat(QuotedCsvText(mapping.tag), " is in ",
                       QuotedCsvText(other), " in the file and wanted in ",
                       QuotedCsvText(unit), ", but scale is 1 and offset 0"));
  }
  table_.tags.push_back(std::move(mapping));
}

absl::StatusOr<TagTable> TagFile::Parse(const std::string& text) {
  std::istringstream in(text);
  CsvRows rows(in, source_);
  const std::string_view first =
      std::string_view(text).substr(0, text.find('\n'));
  if (first.find(',') == std::string_view::npos &&
      first.find(';') != std::string_view::npos) {
    rows.set_separator(';');
  }
  MLE_RETURN_IF_ERROR(ParseHeader(rows));
  while (rows.Next(fields_)) ParseRow(rows);
  MLE_RETURN_IF_ERROR(rows.status());
  if (faults_.empty()) return std::move(table_);
  if (faults_.size() > kShownTagFaults) {
    faults_.resize(kShownTagFaults);
    faults_.emplace_back("…");
  }
  return InvalidArgument(source_, ": ", absl::StrJoin(faults_, ". "));
}

// A tag without its last part: TIC101 of TIC101.SP.
std::string Loop(const std::string& tag) {
  const std::size_t end = tag.find_last_of("._");
  return end == std::string::npos ? tag : tag.substr(0, end);
}

// The nearest channel that is free, if any is near.
std::string NearestChannel(const std::string& tag,
                           const std::set<std::string>& free) {
  std::vector<std::string> names;
  for (const std::string& name : free) {
    if (FoldedName(name) == FoldedName(tag)) return name;
    if (IsSetPointName(name) == IsSetPointTag(tag)) {
      names.push_back(name);
    }
  }
  const std::vector<std::string> near = NearestNames(tag, names, 1);
  return near.empty() ? "" : near[0];
}

}  // namespace

absl::StatusOr<TagTable> ParseTagFile(const std::string& source,
                                      const std::string& text,
                                      const ProcessModel& channels) {
  return TagFile(source, channels).Parse(text);
}

absl::StatusOr<TagTable> ReadTagFile(const std::string& path,
                                     const ProcessModel& channels) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  return ParseTagFile(path, text, channels);
}

absl::StatusOr<std::vector<TagProposal>> ProposeTags(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options) {
  std::vector<TagProposal> proposals;
  std::set<std::string> seen;
  const std::map<std::string, std::string> units = UnitsOf(channels);
  std::set<std::string> free;
  for (const auto& [name, unit] : units) free.insert(name);
  for (const HistorianSource& source : sources) {
    MLE_ASSIGN_OR_RETURN(const HistorianColumns columns,
                         HistorianFile::Columns(source, channels, options));
    const std::vector<std::string> tags =
        sources.size() > 1
            ? TagsOf(source, columns, WantedTags(channels, options.columns))
            : columns.names;
    for (std::size_t t = 0; t < tags.size(); ++t) {
      if (!seen.insert(tags[t]).second) continue;
      proposals.push_back(
          {tags[t], "", "", t < columns.units.size() ? columns.units[t] : ""});
    }
  }
  if (proposals.empty()) {
    return InvalidArgument(
        sources.empty() ? "" : sources[0].name + ": ",
        "no column is one of samples under a name of its own: there is nothing "
        "to propose");
  }
  // Names that agree first, so that no other tag takes their channel.
  for (const bool is_exact : {true, false}) {
    for (TagProposal& proposal : proposals) {
      if (!proposal.channel.empty()) continue;
      const std::string channel = NearestChannel(proposal.tag, free);
      if (channel.empty() ||
          (is_exact && FoldedName(channel) != FoldedName(proposal.tag))) {
        continue;
      }
      proposal.channel = channel;
      proposal.unit = units.at(channel);
      free.erase(channel);
    }
  }
  // The set point of a loop whose output was found.
  for (TagProposal& proposal : proposals) {
    if (!proposal.channel.empty() || !IsSetPointTag(proposal.tag)) continue;
    for (const TagProposal& other : proposals) {
      const std::string channel = SetPointName(other.channel);
      if (other.tag == proposal.tag || !free.contains(channel) ||
          Loop(other.tag) != Loop(proposal.tag)) {
        continue;
      }
      proposal.channel = channel;
      proposal.unit = units.at(channel);
      free.erase(channel);
      break;
    }
  }
  return proposals;
}

std::string FormatTagFile(const std::vector<TagProposal>& proposals) {
  std::string text = "tag,channel,scale,offset,unit,unit in the file\n";
  for (const TagProposal& proposal : proposals) {
    absl::StrAppend(&text, QuoteCsvField(proposal.tag), ",",
                    QuoteCsvField(proposal.channel), ",",
                    proposal.channel.empty() ? ",," : "1,0,",
                    QuoteCsvField(proposal.unit), ",",
                    QuoteCsvField(proposal.found_unit), "\n");
  }
  return text;
}

}  // namespace mle
