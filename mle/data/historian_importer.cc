#include "mle/data/historian_importer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/csv_rows.h"
#include "mle/data/joined_files.h"

namespace mle {
namespace {

constexpr std::size_t kMaxGaps = 100;
// Rows this much farther apart than usual leave a gap.
constexpr double kGapSteps = 1.9;
// Steps from one sample to the next of outputs that are points.
constexpr double kPointSteps = 3.0;
constexpr std::int64_t kRowsOfProgress = 1000;

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
  if (probes_[0].has_dates) {
    import_.report.time_origin = probes_[0].origin;
    import_.report.time_zone = probes_[0].clock.time_zone;
  }
  return ChooseSampleTime(steps);
}

// An error for a row that does not follow the last, or `skip`.
absl::Status HistorianImporter::CheckOrder(const HistorianProbe& probe,
                                           const RowStream& rows, double time,
                                           bool is_first, bool& skip) {
  skip = false;
  if (!has_last_ || time > last_time_) return absl::OkStatus();
  const bool is_repeated = time == last_time_;
  if (!(is_repeated ? options_.skip_repeated_times
                    : options_.skip_backward_times)) {
    return OrderError(probe, rows, time, is_first);
  }
  ++(is_repeated ? import_.report.repeated_rows : import_.report.backward_rows);
  skip = true;
  return absl::OkStatus();
}

absl::Status HistorianImporter::OrderError(const HistorianProbe& probe,
                                           const RowStream& rows, double time,
                                           bool is_first) const {
  const bool is_repeated = time == last_time_;
  const TimeNames times = import_.report.Times(channels_.time_unit());
  const std::string message = absl::StrCat(
      rows.TimePlace(), ": time ", times.Short(time), " ",
      is_repeated ? "is duplicated"
                  : absl::StrCat("follows ", times.Short(last_time_)),
      "; times must increase");
  const std::optional<double> seconds = SecondsPerUnit(channels_.time_unit());
  const double hour = 3600.0 / seconds.value_or(1.0);
  if (seconds && !is_repeated && probe.has_dates &&
      std::abs(last_time_ - time + import_.report.step - hour) <
          0.5 * import_.report.step + 1e-9 * hour) {
    return OptionError(
        "time_zone",
        absl::StrCat(message,
                     ". It goes back by an hour, as clocks do in autumn: "
                     "declare time_zone, such as time_zone = Europe/Berlin"));
  }
  if (is_first && !probe.has_dates) {
    return OptionError(
        "separate_files",
        absl::StrCat(message, ". The files ", probes_[0].source.name, " and ",
                     probe.source.name,
                     " have the same times: if each has a clock of its own, "
                     "separate_files = true takes them one after another"));
  }
  if (is_repeated && probe.rows_of_time > 1) {
    return OptionError(
        "skip_repeated_times,spread_repeated_times",
        absl::StrCat(message, ". ", probe.rows_of_time,
                     " rows share each time: their seconds were lost when the "
                     "file was saved. Export it with seconds, or let rows be "
                     "spread evenly (spread_repeated_times = true), or all but "
                     "the first of each time be ignored (skip_repeated_times "
                     "= true)"));
  }
  if (is_repeated) {
    return OptionError(
        "skip_repeated_times",
        absl::StrCat(message,
                     ", or rows at the same time be ignored "
                     "(skip_repeated_times = true)",
                     probe.repeated_rows > 1
                         ? absl::StrCat("; there are ", probe.repeated_rows,
                                        " of them at the beginning of the file")
                         : ""));
  }
  return OptionError(
      "skip_backward_times",
      absl::StrCat(
          message,
          probe.source.is_table
              ? ": sort the rows (a data frame by sort_index()), or let"
              : ", or",
          " rows that go back be ignored (skip_backward_times = "
          "true)"));
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

// No more samples than allowed to be held, those that the row at `time` brings
// included.
bool HistorianImporter::FitsWithin(double time) {
  if (sink_ != nullptr) return true;
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
    HistorianFile& file, const HistorianProbe& probe,
    const SpreadRows*& spread) const {
  std::unique_ptr<RowStream> rows;
  if (probe.newest_first) {
    rows = std::make_unique<LastRowFirst>(file.rows(), options_.max_samples);
  } else {
    rows = std::make_unique<FileOrder>(file.rows());
  }
  if (options_.spread_repeated_times && probe.rows_of_time > 1) {
    auto spread_rows = std::make_unique<SpreadRows>(
        std::move(rows), probe.time_step, probe.rows_of_time);
    spread = spread_rows.get();
    rows = std::move(spread_rows);
  }
  if (!probe.is_unchanged) return rows;
  return std::make_unique<HeldRows>(std::move(rows), import_.report.step,
                                    PointsOf(probe));
}

// Outputs that a long table has at a few of its times only, by plan: measured
// then, as by a laboratory, and not reported by exception.
std::vector<bool> HistorianImporter::PointsOf(
    const HistorianProbe& probe) const {
  std::vector<bool> points(num_values(), false);
  for (std::size_t v = 0; v < probe.sample_steps.size(); ++v) {
    points[v] = options_.empty_fields == EmptyFields::kRecognise &&
                static_cast<int>(v) < channels_.num_outputs() &&
                probe.sample_steps[v] >= kPointSteps * import_.report.step;
  }
  return points;
}

bool HistorianImporter::TakeRow(const RecordRow& row, Resampler& resampler) {
  bool is_usable = false;
  for (int v = 0; v < num_values(); ++v) {
    if (std::isnan(row.values[v])) continue;
    ++good_[v];
    is_usable = true;
  }
  // A row without a good sample is none.
  if (!is_usable) {
    ++import_.report.empty_rows;
    return true;
  }
  NoteGap(row.time);
  if (!FitsWithin(row.time)) return false;
  resampler.Add(row.time, row.values);
  has_usable_ = true;
  last_usable_ = row.time;
  return true;
}

std::string HistorianImporter::TooManySamples() const {
  return absl::StrCat(": up to here there are more than ", options_.max_samples,
                      " samples, one every ", import_.report.sample_time,
                      "; choose a longer sample_time, or read less at once");
}

absl::Status HistorianImporter::ShowProgress(const FileReport& report,
                                             double fraction) const {
  if (!options_.progress) return absl::OkStatus();
  const TimeNames times = import_.report.Times(channels_.time_unit());
  if (options_.progress({.source = report.name,
                         .rows = report.rows,
                         .reached = times.Short(report.last_time),
                         .fraction = fraction})) {
    return absl::OkStatus();
  }
  return absl::CancelledError(
      absl::StrCat("stopped by the caller while reading ", report.name));
}

absl::Status HistorianImporter::TakeRows(RowStream& rows,
                                         const HistorianProbe& probe,
                                         const HistorianFile* file,
                                         FileReport& report,
                                         Resampler& resampler) {
  const double shift = ShiftOf(probe);
  RecordRow row;
  while (rows.Next(row)) {
    row.time += shift;
    bool skip = false;
    MLE_RETURN_IF_ERROR(
        CheckOrder(probe, rows, row.time, report.rows == 0, skip));
    if (report.rows == 0) report.first_time = row.time;
    ++report.rows;
    if (skip) continue;
    has_last_ = true;
    last_time_ = report.last_time = row.time;
    if (!TakeRow(row, resampler)) {
      return InvalidArgument(rows.TimePlace(), TooManySamples());
    }
    MLE_RETURN_IF_ERROR(collector_->status());
    if (report.rows % kRowsOfProgress == 0) {
      MLE_RETURN_IF_ERROR(
          ShowProgress(report, file == nullptr ? -1.0 : file->FractionRead()));
    }
  }
  return rows.status();
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
  const SpreadRows* spread = nullptr;
  const std::unique_ptr<RowStream> stream = StreamOf(*file, probe, spread);
  MLE_RETURN_IF_ERROR(TakeRows(*stream, probe, file.get(), report, resampler));
  NoteChannels(file->rows(), probe.is_unchanged);
  import_.report.rows += report.rows;
  import_.report.outside_rows += file->rows().passed_over();
  import_.report.comment_rows += file->rows().comments() + file->comment_rows();
  import_.report.repeated_rows += file->repeated_rows();
  if (spread != nullptr) import_.report.spread_rows += spread->spread();
  import_.report.files.push_back(std::move(report));
  return absl::OkStatus();
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

Resampler HistorianImporter::Begin() {
  values_.resize(num_values());
  is_there_.resize(num_values());
  good_.resize(num_values());
  collector_.emplace(MakeCollectorOptions(), sink_);
  ResamplerOptions resampling = {.sample_time = import_.report.sample_time,
                                 .step = import_.report.step,
                                 .max_gap = max_gap_,
                                 .num_outputs = channels_.num_outputs(),
                                 .num_inputs = channels_.num_inputs()};
  Declare(resampling);
  Resampler resampler(resampling, [this](bool begins, double time,
                                         const std::vector<double>& values) {
    collector_->Add(begins, time, values);
  });
  import_.report.averaged = resampler.averages();
  return resampler;
}

absl::StatusOr<HistorianImport> HistorianImporter::End(Resampler& resampler) {
  resampler.Finish();
  collector_->Finish();
  MLE_RETURN_IF_ERROR(collector_->status());
  MLE_RETURN_IF_ERROR(CheckChannels());
  NoteSamples();
  NoteIgnoredRows();
  NoteDeclared();
  Warn();
  return std::move(import_);
}

absl::StatusOr<HistorianImport> HistorianImporter::Run(
    const std::vector<HistorianSource>& sources) {
  MLE_RETURN_IF_ERROR(Probe(sources));
  Resampler resampler = Begin();
  for (const HistorianProbe& probe : probes_) {
    MLE_RETURN_IF_ERROR(ReadSource(probe, resampler));
  }
  return End(resampler);
}

namespace {

// Where columns are missing, files may have a tag each.
absl::StatusOr<HistorianImport> Import(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options, RecordSink* sink) {
  absl::StatusOr<HistorianImport> import =
      HistorianImporter(channels, options, sink).Run(sources);
  if (import.ok() || !absl::StrContains(OptionOf(import.status()), "tags")) {
    return import;
  }
  const std::optional<JoinedFiles> joined =
      JoinFiles(sources, channels, options);
  if (!joined) return import;
  import =
      HistorianImporter(channels, joined->options, sink).Run({joined->source});
  if (!import.ok()) return import;
  import->report.notes.insert(
      import->report.notes.begin(),
      {absl::StrCat(sources.size(),
                    " files with tags of their own, joined by their times."),
       ""});
  return import;
}

}  // namespace

absl::StatusOr<HistorianImport> ImportHistorianSources(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options, RecordSink* sink) {
  MLE_RETURN_IF_ERROR(options.Validate(channels));
  MLE_ASSIGN_OR_RETURN(HistorianImport import,
                       Import(sources, channels, options, sink));
  if (!import.records.empty()) return import;
  const std::string& name = import.report.files[0].name;
  const bool is_table = std::any_of(
      sources.begin(), sources.end(), [&](const HistorianSource& source) {
        return source.name == name && source.is_table;
      });
  return InvalidArgument(
      name, ": ", CsvLineName(2, is_table),
      ", column 1: no two samples follow each other without a "
      "gap longer than max_gap");
}

absl::StatusOr<HistorianImport> ImportHistorian(
    const std::vector<std::string>& paths, const ProcessModel& channels,
    const HistorianOptions& options) {
  std::vector<HistorianSource> sources;
  for (const std::string& path : paths) sources.push_back(FileSource(path));
  return ImportHistorianSources(sources, channels, options);
}

}  // namespace mle
