#include "mle/maintain/records.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "mle/base/double_limits.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/linearise.h"
#include "mle/data/record_columns.h"
#include "mle/maintain/dates.h"
#include "mle/maintain/examine_records.h"
#include "mle/maintain/modes.h"
#include "mle/maintain/record_scan.h"
#include "mle/maintain/used_windows.h"
#include "mle/maintain/whole_windows.h"

namespace mle {
namespace {

// If a channel lacks more than this share of its samples, the report's warnings
// are passed on as warnings, else as notes: the table of the channels has all
// that is missing.
constexpr double kManyMissing = 0.05;
// Samples at rest for each of a window: they cost time, and teach no more.
constexpr int kMostAtRest = 4;

void AddImportWarnings(RecordData& data) {
  bool many = false;
  for (const ChannelReport& channel : data.report.channels) {
    many = many || static_cast<double>(channel.missing) >
                       kManyMissing * static_cast<double>(data.report.samples);
  }
  std::vector<Message>& to = many ? data.warnings : data.notes;
  for (const std::string& warning : data.report.warnings) {
    to.push_back({MessageCode::kImport, "", warning, {}});
  }
  for (const ImportNote& note : data.report.notes) {
    data.notes.push_back({MessageCode::kImport, "", note.text, {}});
    if (!note.option.empty()) data.notes.back().options = {note.option};
  }
}

// Adds the columns that channels without a mapping were read from.
void AddTags(const HistorianReport& report, std::vector<TagMapping>& tags) {
  for (const ChannelReport& channel : report.channels) {
    const bool is_mapped = std::any_of(
        tags.begin(), tags.end(),
        [&](const TagMapping& tag) { return tag.channel == channel.name; });
    if (!is_mapped) tags.push_back({channel.column, channel.name});
  }
}

// Looks at the records as they were imported, and repairs what can be.
absl::Status ExamineFiles(const ProcessModel& model,
                          const ExamineOptions& options, RecordData& data) {
  MLE_ASSIGN_OR_RETURN(data.findings,
                       ExamineRecords(model, options, data.records));
  for (const Finding& finding : data.findings) {
    switch (finding.consequence) {
      case Consequence::kBlocks:
        data.obstacles.push_back(finding.message);
        break;
      case Consequence::kDoubts:
      case Consequence::kRepair:
        data.warnings.push_back(finding.message);
        break;
      case Consequence::kNote:
        data.notes.push_back(finding.message);
        break;
    }
  }
  return absl::OkStatus();
}

// The window of `record`, and before it up to `most` samples of its inputs.
Record WithLead(const Record& record, const SetPointWindow& window, int most) {
  const int earliest = std::max(window.first_sample - most, 0);
  int begin = window.first_sample;
  while (begin > earliest &&
         record.inputs.col(begin - 1).array().isFinite().all()) {
    --begin;
  }
  const int lead = window.first_sample - begin;
  if (lead <= 0) return window.record;
  const int samples = lead + window.record.samples();
  Record whole;
  whole.start_time = record.time(begin);
  whole.sample_time = record.sample_time;
  whole.outputs =
      Eigen::MatrixXd::Constant(record.num_outputs(), samples, kNaN);
  whole.outputs.rightCols(window.record.samples()) = window.record.outputs;
  whole.inputs.resize(record.num_inputs(), samples);
  whole.inputs << record.inputs.middleCols(begin, lead), window.record.inputs;
  if (window.record.set_points.size() > 0) {
    whole.set_points.resize(record.num_outputs(), samples);
    whole.set_points << record.set_points.middleCols(begin, lead),
        window.record.set_points;
  }
  return whole;
}

// Finds what is wrong with the channels, and marks what is not to be used.
void MarkUnhealthy(const ProcessModel& model, const MarkOptions& mark,
                   RecordData& data) {
  data.health = CheckHealth(data.records, model, HealthOptions());
  for (const ChannelHealth& channel : data.health.channels) {
    if (channel.is_healthy()) continue;
    for (const absl::string_view line :
         absl::StrSplit(channel.Report(data.records, data.Times(model)), '\n',
                        absl::SkipWhitespace())) {
      data.notes.push_back({MessageCode::kChannel,
                            channel.name,
                            std::string(absl::StripAsciiWhitespace(line)),
                            {}});
    }
  }
  if (const int marked = MarkBad(data.health, mark, data.records); marked > 0) {
    data.notes.push_back(
        {MessageCode::kSamplesMarked,
         "",
         absl::StrCat(marked, " of these samples are marked as bad."),
         {"mark_outliers", "mark_frozen"}});
  }
}

// Beyond what a controller makes of noise: it moves inputs in steady operation
// too.
constexpr double kLargeDeviation = 3.0;  // of the noise's standard deviation

bool IsLarge(const SteadyOperation& part) {
  return std::abs(part.size) > kLargeDeviation * part.noise;
}

void WarnOfNonStationary(const ProcessModel& model, RecordData& data) {
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    const std::vector<std::string> non_stationary =
        NonStationaryIn(data.windows[w], model);
    if (non_stationary.empty()) continue;
    const std::string name = absl::StrCat("Window ", w + 1);
    data.warnings.push_back(
        {MessageCode::kWindowNotAtRest,
         name,
         absl::StrCat(name, " is not at rest where it should be: ",
                      absl::StrJoin(non_stationary, ", "),
                      ". An unmeasured disturbance widens the intervals."),
         {}});
  }
}

// The same channels and sample time in all records.
absl::Status CheckRecords(const std::vector<Record>& records,
                          const ProcessModel& model) {
  if (records.empty()) {
    return absl::InvalidArgumentError("there are no records");
  }
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Record& record = records[r];
    const std::string name = absl::StrCat("record ", r + 1);
    if (const absl::Status status = record.Validate(); !status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, ": ", status.message()));
    }
    if (record.num_outputs() != model.num_outputs() ||
        record.num_inputs() != model.num_inputs()) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, " has ", record.num_outputs(), " outputs and ",
                       record.num_inputs(), " inputs; the model has ",
                       model.num_outputs(), " and ", model.num_inputs()));
    }
    if (!(std::abs(record.sample_time - records.front().sample_time) <=
          1e-9 * records.front().sample_time)) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, " is sampled every ", record.sample_time,
                       ", the first record every ", records.front().sample_time,
                       "; they must be alike"));
    }
  }
  return absl::OkStatus();
}

// Health and windows of data.records.
absl::Status FindWhatIsUsed(const ProcessModel& model,
                            const RecordOptions& options, RecordData& data) {
  data.lead = static_cast<int>(
      std::min(std::ceil(SettlingTime(model) / data.sample_time()), 1e9));
  for (const OutputChannel& output : model.outputs()) {
    data.sampling.push_back(SamplingOf(output, options.examination.tags));
  }
  for (Record& record : data.records) {
    MLE_RETURN_IF_ERROR(Linearise(model, record));
  }
  AddImportWarnings(data);
  MLE_RETURN_IF_ERROR(ExamineFiles(model, options.examination, data));
  MarkUnhealthy(model, options.mark, data);
  MLE_RETURN_IF_ERROR(FindUsedWindows(model, options, data));
  WarnOfNonStationary(model, data);
  return absl::OkStatus();
}

}  // namespace

std::vector<Record> RecordData::Records() const {
  std::vector<Record> result;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const SetPointWindow& window = windows[w];
    const bool adjoins = w > 0 && Adjoin(windows[w - 1], window);
    result.push_back(adjoins ? window.record
                             : WithLead(records[window.source], window, lead));
  }
  return result;
}

std::vector<Record> RecordData::AtRest() const {
  int left = 0;
  std::vector<std::vector<std::pair<int, int>>> taken(records.size());
  for (const SetPointWindow& window : windows) {
    left += kMostAtRest * window.record.samples();
    taken[window.source].emplace_back(
        window.first_sample, window.first_sample + window.record.samples());
  }
  for (const UnusedPart& part : unused) {
    taken[part.source].emplace_back(part.first_sample,
                                    part.first_sample + part.samples);
  }
  std::vector<Record> rest;
  for (auto r = static_cast<int>(records.size()) - 1; r >= 0; --r) {
    // Backwards from the end of the record.
    std::sort(taken[r].begin(), taken[r].end());
    taken[r].insert(taken[r].begin(), {0, 0});
    int end = records[r].samples();
    for (auto part = taken[r].rbegin(); part != taken[r].rend(); ++part) {
      const int begin = std::max(part->second, end - left);
      absl::StatusOr<Record> between =
          CutWindow(records[r], begin, 0.0, (end - 1 - begin) * sample_time());
      if (end > begin && between.ok()) {
        left -= between->samples();
        rest.push_back(*std::move(between));
      }
      end = std::min(end, part->first);
    }
  }
  return rest;
}

double BeginOf(const SetPointWindow& window) { return window.record.time(0); }

double EndOf(const SetPointWindow& window) {
  return window.record.time(window.record.samples() - 1);
}

std::vector<std::string> NonStationaryIn(const SetPointWindow& window,
                                         const ProcessModel& model) {
  std::vector<std::string> non_stationary;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (const auto* parts : {&window.before, &window.after}) {
      if (i >= static_cast<int>(parts->size())) continue;
      const SteadyOperation& part = (*parts)[i];
      const bool drifts = part.verdict == SteadyOperation::Verdict::kDrifting;
      const bool steps = part.verdict == SteadyOperation::Verdict::kDisturbed;
      if (!IsLarge(part) || (!drifts && !steps)) continue;
      non_stationary.push_back(absl::StrCat(
          model.outputs()[i].name, drifts ? " drifts" : " steps",
          parts == &window.before ? " before the change" : " at the end"));
    }
  }
  return non_stationary;
}

absl::Status ExamineOptions::Validate() const {
  if (threads < 0) {
    return OptionError("threads", absl::StrCat("threads = ", threads,
                                               ": it must not be negative"));
  }
  return absl::OkStatus();
}

absl::Status RecordOptions::Validate() const {
  MLE_RETURN_IF_ERROR(examination.Validate());
  for (const auto& [name, value] :
       {std::pair("most_samples", most_samples),
        std::pair("most_samples_in_memory", most_samples_in_memory)}) {
    if (value >= 0) continue;
    return OptionError(
        name, absl::StrCat(name, " = ", value, ": it must not be negative"));
  }
  return windows.Validate();
}

absl::StatusOr<RecordData> PrepareRecords(std::vector<Record> records,
                                          const ProcessModel& model,
                                          const RecordOptions& options) {
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(CheckRecords(records, model));
  RecordData data;
  data.records = std::move(records);
  data.report.sample_time = data.records.front().sample_time;
  data.report.records = static_cast<int>(data.records.size());
  for (const Record& record : data.records) {
    data.report.samples += record.samples();
  }
  data.report.kept_samples = data.report.samples;
  MLE_RETURN_IF_ERROR(FindWhatIsUsed(model, options, data));
  return data;
}

absl::StatusOr<RecordData> ImportAndPrepare(const ImportOf& import,
                                            const ProcessModel& model,
                                            const HistorianOptions& importing,
                                            const RecordOptions& options) {
  HistorianOptions told = importing;
  for (const ModeTag& mode : options.modes) {
    told.columns.unused_tags.push_back(mode.tag);
  }
  MLE_ASSIGN_OR_RETURN(HistorianImport imported, import(model, told));
  RecordOptions mapped = options;
  mapped.examination.tags = importing.columns.tags;
  MLE_ASSIGN_OR_RETURN(Modes modes, ReadModes(import, model, importing,
                                              options.modes, imported.records));
  mapped.windows.by_hand = std::move(modes.by_hand);
  MLE_ASSIGN_OR_RETURN(RecordData data,
                       PrepareRecords(std::move(imported), model, mapped));
  for (Message& note : modes.notes) data.notes.push_back(std::move(note));
  return data;
}

absl::StatusOr<RecordData> LoadSources(
    const std::vector<HistorianSource>& sources, const ProcessModel& model,
    const HistorianOptions& import, const RecordOptions& options,
    const ProgressCallback& progress) {
  RecordScan scan(model, options.most_samples_in_memory);
  const bool scans = options.most_samples_in_memory > 0;
  const auto read = [&](const ProcessModel& channels, HistorianOptions told) {
    // Of what is read again, nothing is told.
    const bool whole = &channels == &model;
    if (progress && whole) {
      told.progress = [&](const ImportProgress& reading) {
        return progress(
            {absl::StrCat(
                 "reading ", reading.source,
                 reading.fraction < 0.0 ? " up to " + reading.reached : ""),
             std::max(reading.fraction, 0.0)});
      };
    }
    return ImportHistorianSources(sources, channels, told,
                                  scans && whole ? &scan : nullptr);
  };
  MLE_ASSIGN_OR_RETURN(RecordData data,
                       ImportAndPrepare(read, model, import, options));
  for (Message& note : scan.Notes()) data.notes.push_back(std::move(note));
  return data;
}

absl::StatusOr<RecordData> LoadRecords(const std::vector<std::string>& paths,
                                       const ProcessModel& model,
                                       const HistorianOptions& import,
                                       const RecordOptions& options,
                                       const ProgressCallback& progress) {
  std::vector<HistorianSource> sources;
  for (const std::string& path : paths) sources.push_back(FileSource(path));
  return LoadSources(sources, model, import, options, progress);
}

absl::StatusOr<RecordData> PrepareRecords(HistorianImport imported,
                                          const ProcessModel& model,
                                          const RecordOptions& options) {
  MLE_RETURN_IF_ERROR(CheckRecords(imported.records, model));
  RecordData data;
  data.records = std::move(imported.records);
  data.report = std::move(imported.report);
  RecordOptions dated = options;
  dated.windows.times = dated.examination.times = data.Times(model);
  AddTags(data.report, dated.examination.tags);
  MLE_RETURN_IF_ERROR(AddDates("change_times", options.change_dates,
                               data.report, model, dated.windows.change_times));
  MLE_RETURN_IF_ERROR(AddDates("leave_out", options.leave_out_dates,
                               data.report, model, dated.leave_out));
  MLE_RETURN_IF_ERROR(FindWhatIsUsed(model, dated, data));
  return data;
}

RecordData UseAsWindows(std::vector<Record> windows) {
  RecordData data;
  if (!windows.empty()) data.report.sample_time = windows.front().sample_time;
  data.records = std::move(windows);
  for (std::size_t r = 0; r < data.records.size(); ++r) {
    data.windows.push_back(WholeWindow(data.records[r], r));
  }
  return data;
}

}  // namespace mle
