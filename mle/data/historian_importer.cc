#include "mle/data/historian_importer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/usual_step.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

constexpr std::size_t kMaxGaps = 100;
constexpr double kDefaultGapSteps = 5.0;
// A Δt finer than this share of the files' step invents its samples.
constexpr double kMaxRefinement = 50.0;
// Rows this much farther apart than usual leave a gap.
constexpr double kGapSteps = 1.9;
// Samples this much finer than rows are mostly interpolated.
constexpr double kCoarse = 1.5;

}  // namespace

absl::Status HistorianImporter::Probe(
    const std::vector<HistorianSource>& sources) {
  if (sources.empty()) {
    return absl::InvalidArgumentError(
        "historian: there is no file to read, at least 1 is needed");
  }
  if (options_.clocks.size() > 1 && options_.clocks.size() != sources.size()) {
    return OptionError(
        "time_format,number_unit,time_zone",
        absl::StrCat("time_format, number_unit and time_zone must have one "
                     "value, or one for each of the ",
                     sources.size(), " files; there are ",
                     options_.clocks.size()));
  }
  std::vector<double> steps;
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const ClockOptions& clock =
        options_.clocks.empty()
            ? options_.clock
            : options_.clocks[std::min(s, options_.clocks.size() - 1)];
    MLE_ASSIGN_OR_RETURN(
        HistorianProbe probe,
        ProbeHistorian(sources[s], channels_, options_, clock));
    steps.insert(steps.end(), probe.steps.begin(), probe.steps.end());
    probes_.push_back(std::move(probe));
  }
  for (const HistorianProbe& probe : probes_) {
    if (probe.has_dates == probes_[0].has_dates) continue;
    return OptionError(
        "time_format",
        absl::StrCat(probe.source.name, ": its times are ",
                     probe.has_dates ? "dates" : "numbers", " (",
                     probe.time_form, "), those of ", probes_[0].source.name,
                     " are not (", probes_[0].time_form,
                     "); files that are joined must agree. time_format may "
                     "have one value for each file"));
  }
  if (!probes_[0].has_dates && options_.separate_files) {
    return ChooseSampleTime(steps);
  }
  std::stable_sort(
      probes_.begin(), probes_.end(), [](const auto& a, const auto& b) {
        return a.has_dates ? a.origin < b.origin : a.first_time < b.first_time;
      });
  if (probes_[0].has_dates) import_.report.time_origin = probes_[0].origin;
  return ChooseSampleTime(steps);
}

absl::Status HistorianImporter::ChooseSampleTime(
    const std::vector<double>& steps) {
  HistorianReport& report = import_.report;
  if (steps.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        probes_[0].source.name,
        ": line 2, column 1: no row is later than the one before it; a record "
        "needs at least 2 rows at different times"));
  }
  report.step = UsualStep(steps);
  report.sample_time =
      options_.sample_time > 0.0 ? options_.sample_time : report.step;
  if (report.step > kMaxRefinement * report.sample_time) {
    return absl::InvalidArgumentError(absl::StrCat(
        probes_[0].source.name, ": sample_time is ", report.sample_time,
        ", but rows are ", report.step, " apart; it must be at least ",
        report.step / kMaxRefinement, ", better not below ", report.step));
  }
  max_gap_ = options_.max_gap >= 0.0
                 ? options_.max_gap
                 : kDefaultGapSteps * std::max(report.step, report.sample_time);
  return absl::OkStatus();
}

// An error for a row that does not follow the last, or `skip`.
absl::Status HistorianImporter::CheckOrder(const HistorianFile& file,
                                           const RowStream& rows, double time,
                                           bool is_first, bool& skip) {
  skip = false;
  if (!has_last_ || time > last_time_) return absl::OkStatus();
  const bool is_repeated = time == last_time_;
  if (!(is_repeated ? options_.skip_repeated_times
                    : options_.skip_backward_times)) {
    return OrderError(file, rows, time, is_first);
  }
  ++(is_repeated ? import_.report.repeated_rows : import_.report.backward_rows);
  skip = true;
  return absl::OkStatus();
}

absl::Status HistorianImporter::OrderError(const HistorianFile& file,
                                           const RowStream& rows, double time,
                                           bool is_first) const {
  const bool is_repeated = time == last_time_;
  const std::string message = absl::StrCat(
      rows.TimePlace(), ": time ", time, " ",
      is_repeated ? "stands twice" : absl::StrCat("follows ", last_time_),
      "; times must increase");
  const std::optional<double> seconds = file.clock().seconds_per_unit();
  const double hour = 3600.0 / seconds.value_or(1.0);
  const bool has_dates = file.clock().has_dates();
  if (seconds && !is_repeated && has_dates &&
      std::abs(last_time_ - time + import_.report.step - hour) <
          0.5 * import_.report.step + 1e-9 * hour) {
    return OptionError(
        "time_zone",
        absl::StrCat(message,
                     ". It goes back by an hour, as clocks do in autumn: "
                     "declare time_zone, such as time_zone = Europe/Berlin"));
  }
  if (is_first && !has_dates) {
    return OptionError(
        "separate_files",
        absl::StrCat(message, ". The files ", probes_[0].source.name, " and ",
                     file.report().name,
                     " have the same times: if each has a clock of its own, "
                     "separate_files = true takes them one after another"));
  }
  const char* const option =
      is_repeated ? "skip_repeated_times" : "skip_backward_times";
  return OptionError(
      option, absl::StrCat(message, ", or rows ",
                           is_repeated ? "at the same time" : "that go back",
                           " be ignored (", option, " = true)"));
}

// Beyond the last row so far by more than any gap that is bridged.
double HistorianImporter::ShiftOf(const HistorianProbe& probe) const {
  if (!options_.separate_files || probe.has_dates || !has_last_) return 0.0;
  const double sample_time = import_.report.sample_time;
  const double gap =
      max_gap_ + 2.0 * kGapSteps * std::max(import_.report.step, sample_time);
  return last_time_ + (std::floor(gap / sample_time) + 1.0) * sample_time -
         probe.first_time;
}

void HistorianImporter::NoteForm(const HistorianProbe& probe,
                                 FileReport& report) {
  report.time_form = probe.time_form;
  report.newest_first = probe.newest_first;
  if (probe.newest_first) {
    import_.report.notes.push_back(
        absl::StrCat(probe.source.name,
                     ": the newest rows stand first; it was turned "
                     "round."));
  }
}

// No more samples than allowed, those that the row at `time` brings included.
bool HistorianImporter::FitsWithin(double time) {
  const HistorianReport& report = import_.report;
  double due = 1.0;
  if (has_usable_) {
    const double apart = time - last_usable_;
    if (apart <= max_gap_ + kGapSteps * report.step) {
      due = apart / report.sample_time;
    }
  }
  return static_cast<double>(collector_->samples()) + due <=
         static_cast<double>(options_.max_samples);
}

void HistorianImporter::NoteGap(double time) {
  HistorianReport& report = import_.report;
  if (!has_usable_) return;
  const double apart = time - last_usable_;
  if (apart <= kGapSteps * std::max(report.step, report.sample_time)) return;
  ++report.num_gaps;
  if (report.gaps.size() < kMaxGaps) {
    report.gaps.push_back(
        {last_usable_, time, apart > max_gap_ + kGapSteps * report.step});
  }
}

std::unique_ptr<RowStream> HistorianImporter::StreamOf(
    HistorianFile& file, const HistorianProbe& probe) const {
  if (probe.newest_first) {
    return std::make_unique<LastRowFirst>(file.rows(), options_.max_samples);
  }
  return std::make_unique<FileOrder>(file.rows());
}

absl::Status HistorianImporter::ReadSource(const HistorianProbe& probe,
                                           Resampler& resampler) {
  MLE_ASSIGN_OR_RETURN(
      const std::unique_ptr<HistorianFile> file,
      HistorianFile::Open(probe.source, channels_, options_, probe.clock,
                          import_.report.time_origin));
  file->clock().set_descending(probe.newest_first);
  FileReport report = file->report();
  NoteForm(probe, report);
  const std::unique_ptr<RowStream> stream = StreamOf(*file, probe);
  RowStream& rows = *stream;
  const double shift = ShiftOf(probe);
  RecordRow row;
  while (rows.Next(row)) {
    row.time += shift;
    bool skip = false;
    MLE_RETURN_IF_ERROR(
        CheckOrder(*file, rows, row.time, report.rows == 0, skip));
    if (report.rows == 0) report.first_time = row.time;
    ++report.rows;
    if (skip) continue;
    has_last_ = true;
    last_time_ = report.last_time = row.time;
    bool is_usable = false;
    for (int v = 0; v < num_values(); ++v) {
      if (std::isnan(row.values[v])) continue;
      ++good_[v];
      is_usable = true;
    }
    // A row without a good sample is none.
    if (!is_usable) continue;
    NoteGap(row.time);
    if (!FitsWithin(row.time)) {
      return absl::InvalidArgumentError(
          absl::StrCat(rows.TimePlace(), ": up to here there are more than ",
                       options_.max_samples, " samples, one every ",
                       import_.report.sample_time,
                       "; choose a longer sample_time, or read less at once"));
    }
    resampler.Add(row.time, row.values);
    has_usable_ = true;
    last_usable_ = row.time;
  }
  MLE_RETURN_IF_ERROR(rows.status());
  NoteChannels(file->rows());
  import_.report.rows += report.rows;
  import_.report.files.push_back(std::move(report));
  return absl::OkStatus();
}

void HistorianImporter::NoteChannels(const RecordRows& rows) {
  const int p = channels_.num_outputs();
  for (const RecordColumn& column : rows.columns()) {
    int value = column.channel;
    std::string name;
    if (column.kind == Kind::kOutput) {
      name = channels_.outputs()[column.channel].name;
    } else if (column.kind == Kind::kSetPoint) {
      name = channels_.outputs()[column.channel].name + "_setpoint";
      value += p;
    } else if (column.kind == Kind::kInput) {
      name = channels_.inputs()[column.channel].name;
      value += 2 * p;
    } else {
      continue;
    }
    is_there_[value] = true;
    ChannelReport& report = values_[value];
    report.name = name;
    report.column = column.name;
    const BadSampleCounts& bad = rows.bad()[value];
    report.bad.empty += bad.empty;
    report.bad.not_a_number += bad.not_a_number;
    report.bad.declared += bad.declared;
    report.bad.quality += bad.quality;
  }
  for (const std::string& quality : rows.bad_qualities()) {
    if (std::find(bad_qualities_.begin(), bad_qualities_.end(), quality) ==
        bad_qualities_.end()) {
      bad_qualities_.push_back(quality);
    }
  }
}

CollectorOptions HistorianImporter::MakeCollectorOptions() const {
  const HistorianReport& report = import_.report;
  CollectorOptions options;
  options.num_outputs = channels_.num_outputs();
  options.num_inputs = channels_.num_inputs();
  options.sample_time = report.sample_time;
  for (const HistorianProbe& probe : probes_) {
    options.has_set_points |= probe.has_set_points;
  }
  const double longest =
      max_gap_ + std::max(report.step - report.sample_time, 0.0);
  options.max_bridged = static_cast<int>(
      std::min(std::floor(longest / report.sample_time + 0.5), 1e9));
  return options;
}

void HistorianImporter::NoteSamples() {
  HistorianReport& report = import_.report;
  import_.records = collector_->TakeRecords();
  for (int v = 0; v < num_values(); ++v) {
    if (!is_there_[v]) continue;
    values_[v].bridged = collector_->bridged()[v];
    values_[v].missing = collector_->missing()[v];
    report.channels.push_back(values_[v]);
  }
  report.records = static_cast<int>(import_.records.size());
  for (const Record& record : import_.records) {
    report.samples += record.samples();
  }
}

absl::Status HistorianImporter::CheckChannels() {
  for (int v = 0; v < num_values(); ++v) {
    if (!is_there_[v] || good_[v] > 0) continue;
    const ChannelReport& channel = values_[v];
    if (channel.bad.quality == 0) {
      return absl::InvalidArgumentError(absl::StrCat(
          probes_[0].source.name, ": column '", ShowCsvText(channel.column),
          "' has no good sample in any row (", channel.bad.empty, " empty, ",
          channel.bad.not_a_number, " NaN, ", channel.bad.declared,
          " bad values); the channel '", channel.name, "' needs samples"));
    }
    return absl::InvalidArgumentError(absl::StrCat(
        probes_[0].source.name, ": column '", ShowCsvText(channel.column),
        "' has no good sample, as its quality says; the qualities found are '",
        absl::StrJoin(bad_qualities_, "', '"),
        "'; declare which of them mean good"));
  }
  return absl::OkStatus();
}

void HistorianImporter::Warn() {
  HistorianReport& report = import_.report;
  if (report.step > kCoarse * report.sample_time) {
    report.warnings.push_back(absl::StrCat(
        "rows are ", report.step, " apart, more than the sample time ",
        report.sample_time,
        ": most outputs are interpolated, and their noise is not white; choose "
        "a sample time not below the step"));
  }
  if (collector_->short_pieces() > 0) {
    report.warnings.push_back(
        absl::StrCat(collector_->short_pieces(),
                     " single samples between long gaps are "
                     "left out"));
  }
  for (const ChannelReport& channel : report.channels) {
    if (channel.missing > 0) {
      report.warnings.push_back(absl::StrCat("'", channel.name, "' has ",
                                             channel.missing,
                                             " samples that stay bad"));
    }
  }
}

absl::StatusOr<HistorianImport> HistorianImporter::Run(
    const std::vector<HistorianSource>& sources) {
  MLE_RETURN_IF_ERROR(Probe(sources));
  values_.resize(num_values());
  is_there_.resize(num_values());
  good_.resize(num_values());
  collector_.emplace(MakeCollectorOptions());
  Resampler resampler(
      {.sample_time = import_.report.sample_time,
       .step = import_.report.step,
       .max_gap = max_gap_,
       .num_outputs = channels_.num_outputs(),
       .num_inputs = channels_.num_inputs()},
      [this](bool begins, double time, const std::vector<double>& values) {
        collector_->Add(begins, time, values);
      });
  import_.report.averaged = resampler.averages();
  for (const HistorianProbe& probe : probes_) {
    MLE_RETURN_IF_ERROR(ReadSource(probe, resampler));
  }
  resampler.Finish();
  collector_->Finish();
  MLE_RETURN_IF_ERROR(CheckChannels());
  NoteSamples();
  Warn();
  return std::move(import_);
}

}  // namespace mle
