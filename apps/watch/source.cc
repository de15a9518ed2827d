#include "apps/watch/source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/linearise.h"
#include "mle/data/tag_file.h"
#include "mle/database/record_sources.h"

namespace mle::watch {
namespace {

namespace fs = std::filesystem;

// Longer than ModelWatch::lead().
constexpr double kSettlingTimes = 3.0;
// Options that an empty part of a table is about.
constexpr std::string_view kRange = "begin,end";

bool IsExport(const std::string& name) {
  return absl::EndsWith(name, ".csv") || absl::EndsWith(name, ".txt") ||
         absl::EndsWith(name, ".csv.gz") || absl::EndsWith(name, ".txt.gz");
}

absl::Status WrongFolder(const std::string& folder,
                         const std::error_code& error) {
  return InvalidArgument("records: ", folder, ": ", error.message(),
                         "; it must be a folder of CSV files");
}

// Reads all of `paths`; those that cannot be read get a fault.
absl::StatusOr<HistorianImport> ImportReadable(
    std::vector<std::string>& paths, const ProcessModel& model,
    const HistorianOptions& options,
    std::map<std::string, std::string>& faults) {
  absl::StatusOr<HistorianImport> all = ImportHistorian(paths, model, options);
  if (all.ok()) return all;
  std::vector<std::string> readable;
  for (const std::string& path : paths) {
    const absl::StatusOr<HistorianImport> one =
        ImportHistorian({path}, model, options);
    if (one.ok()) {
      readable.push_back(path);
    } else {
      faults[path] = std::string(one.status().message());
    }
  }
  // Each can be read, but not together.
  if (readable.empty() || readable.size() == paths.size()) return all.status();
  paths = std::move(readable);
  return ImportHistorian(paths, model, options);
}

// As dated records, in the variables in which the model is linear, and the
// times of each file.
absl::StatusOr<DatedRecords> WithDates(
    HistorianImport import, const ProcessModel& model, double seconds_per_unit,
    std::map<std::string, std::pair<double, double>>& times) {
  if (!import.report.time_origin.has_value()) {
    return absl::InvalidArgumentError(
        "records: times are numbers without dates; a watch needs dates (such "
        "as 2024-02-29 12:34) to tell days");
  }
  for (Record& record : import.records) {
    if (const absl::Status status = Linearise(model, record); !status.ok()) {
      return WithPrefix(status, "records: ");
    }
  }
  const double origin = *import.report.time_origin;
  for (const FileReport& file : import.report.files) {
    times[file.name] = {origin + file.first_time * seconds_per_unit,
                        origin + file.last_time * seconds_per_unit};
  }
  DatedRecords dated{.records = std::move(import.records),
                     .seconds_per_unit = seconds_per_unit};
  for (Record& record : dated.records) {
    record.start_time = origin + record.start_time * seconds_per_unit;
  }
  return dated;
}

// With rows in these seconds since 1970, of the folder as it is named now:
// under another name the same files have been read before.
std::vector<std::string> FilesBetween(const std::string& folder,
                                      const Watch& watch, double from,
                                      double to) {
  std::vector<std::string> paths;
  for (const auto& [path, file] : watch.files) {
    const bool is_of_folder =
        (fs::path(folder) / fs::path(path).filename()).string() == path;
    if (is_of_folder && file.fault.empty() && file.last >= from &&
        file.first <= to && fs::exists(path)) {
      paths.push_back(path);
    }
  }
  return paths;
}

class NewFiles {
 public:
  NewFiles(const Controller& controller, const ProcessModel& model,
           const Watch& watch, HistorianOptions options,
           double seconds_per_unit)
      : controller_(controller),
        model_(model),
        watch_(watch),
        options_(std::move(options)),
        seconds_per_unit_(seconds_per_unit) {}

  absl::StatusOr<std::optional<NewRecords>> Read();

 private:
  absl::Status List();
  absl::Status Import();
  // Adds the records of known files that act on the new ones, or complete their
  // days.
  absl::Status AddAround();

  const Controller& controller_;
  const ProcessModel& model_;
  const Watch& watch_;
  HistorianOptions options_;
  double seconds_per_unit_;
  std::vector<std::string> paths_;  // new or changed
  NewRecords result_;
};

absl::Status NewFiles::List() {
  MLE_ASSIGN_OR_RETURN(const auto listed, ListFiles(controller_.records));
  for (const auto& [path, file] : listed) {
    const auto seen = watch_.files.find(path);
    if (seen != watch_.files.end() && seen->second.bytes == file.bytes &&
        seen->second.changed == file.changed) {
      continue;
    }
    result_.files[path] = file;
    paths_.push_back(path);
  }
  return absl::OkStatus();
}

absl::Status NewFiles::Import() {
  std::map<std::string, std::string> faults;
  std::map<std::string, std::pair<double, double>> times;
  const std::size_t count = paths_.size();
  absl::StatusOr<HistorianImport> import =
      ImportReadable(paths_, model_, options_, faults);
  if (import.ok()) {
    MLE_ASSIGN_OR_RETURN(result_.data, WithDates(*std::move(import), model_,
                                                 seconds_per_unit_, times));
  } else if (faults.size() != count) {
    return import.status();
  }
  result_.first = std::numeric_limits<double>::infinity();
  result_.last = -result_.first;
  for (auto& [path, file] : result_.files) {
    if (const auto found = times.find(path); found != times.end()) {
      file.first = found->second.first;
      file.last = found->second.second;
      result_.first = std::min(result_.first, file.first);
      result_.last = std::max(result_.last, file.last);
    } else {
      file.fault = faults[path];
      result_.faults.push_back(
          absl::StrCat(path, " cannot be read: ", file.fault));
    }
  }
  return absl::OkStatus();
}

absl::Status NewFiles::AddAround() {
  std::vector<std::string> all = paths_;
  const double around =
      kSecondsOfDay + kSettlingTimes * SettlingTime(model_) * seconds_per_unit_;
  for (const std::string& path :
       FilesBetween(controller_.records, watch_, result_.first - around,
                    result_.last + around)) {
    if (!result_.files.contains(path)) all.push_back(path);
  }
  if (all.size() == paths_.size()) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(HistorianImport together,
                       ImportHistorian(all, model_, options_));
  std::map<std::string, std::pair<double, double>> times;
  MLE_ASSIGN_OR_RETURN(result_.data, WithDates(std::move(together), model_,
                                               seconds_per_unit_, times));
  return absl::OkStatus();
}

absl::StatusOr<std::optional<NewRecords>> NewFiles::Read() {
  MLE_RETURN_IF_ERROR(List());
  if (paths_.empty()) return std::nullopt;
  MLE_RETURN_IF_ERROR(Import());
  if (!result_.data.records.empty()) MLE_RETURN_IF_ERROR(AddAround());
  return std::move(result_);
}

// That no row is in the time range is no fault of a database.
bool IsEmptyRange(const absl::Status& status) {
  return OptionOf(status) == kRange;
}

absl::StatusOr<std::optional<NewRecords>> ReadNewRows(
    const Controller& controller, const ProcessModel& model, const Watch& watch,
    HistorianOptions options, double seconds_per_unit) {
  NewRecords result;
  result.first = -std::numeric_limits<double>::infinity();
  if (watch.reference.has_value()) {
    result.first =
        (watch.last_day() + 1 - controller.overlap_days) * kSecondsOfDay;
    const double around =
        kSettlingTimes * SettlingTime(model) * seconds_per_unit / kSecondsOfDay;
    options.begin =
        FormatIsoTime(result.first - (1.0 + std::ceil(around)) * kSecondsOfDay);
  }
  MLE_ASSIGN_OR_RETURN(
      const std::vector<HistorianSource> sources,
      RecordSources({controller.records}, controller.database, options));
  absl::StatusOr<HistorianImport> import =
      ImportHistorianSources(sources, model, options);
  if (!import.ok()) {
    if (watch.reference.has_value() && IsEmptyRange(import.status())) {
      return std::nullopt;
    }
    return WithPrefix(import.status(), "records: ");
  }
  std::map<std::string, std::pair<double, double>> times;
  MLE_ASSIGN_OR_RETURN(result.data, WithDates(*std::move(import), model,
                                              seconds_per_unit, times));
  for (const auto& [name, time] : times) result.last = time.second;
  return result;
}

}  // namespace

absl::StatusOr<double> SecondsOf(const ProcessModel& model) {
  const std::optional<double> seconds = SecondsPerUnit(model.time_unit());
  if (seconds.has_value()) return *seconds;
  return InvalidArgument("model: its time unit is \"", model.time_unit(),
                         "\"; s, min, h or d is needed to tell days");
}

absl::StatusOr<HistorianOptions> ImportOptionsOf(const Controller& controller,
                                                 const ProcessModel& model) {
  HistorianOptions options;
  options.sample_time = controller.sample_time;
  options.begin = controller.begin;
  options.clock.time_zone = controller.time_zone;
  options.columns.ignore_other_columns = true;
  options.any_word_is_bad = true;
  options.skip_repeated_times = true;
  if (!controller.tag_file.empty()) {
    MLE_ASSIGN_OR_RETURN(TagTable table,
                         ReadTagFile(controller.tag_file, model));
    options.columns.tags = std::move(table.tags);
  }
  MLE_RETURN_IF_ERROR(options.Validate(model));
  return options;
}

absl::StatusOr<std::map<std::string, SeenFile>> ListFiles(
    const std::string& folder) {
  std::error_code error;
  std::map<std::string, SeenFile> files;
  fs::directory_iterator entry(folder, error);
  if (error) return WrongFolder(folder, error);
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    if (error) return WrongFolder(folder, error);
    std::error_code gone;
    if (!IsExport(entry->path().filename().string()) ||
        !entry->is_regular_file(gone)) {
      continue;
    }
    const auto bytes = entry->file_size(gone);
    const auto changed = entry->last_write_time(gone);
    // Removed while the folder is read.
    if (gone) continue;
    files[entry->path().string()] = {
        .bytes = static_cast<std::int64_t>(bytes),
        .changed =
            std::chrono::duration_cast<std::chrono::nanoseconds>(
                fs::file_time_type::clock::to_sys(changed).time_since_epoch())
                .count()};
  }
  return files;
}

std::vector<std::string> SourcesBetween(const Controller& controller,
                                        const Watch& watch, double from,
                                        double to, HistorianOptions& options) {
  options.begin = FormatIsoTime(from);
  options.end = FormatIsoTime(to);
  if (IsDatabase(controller.records)) return {controller.records};
  return FilesBetween(controller.records, watch, from, to);
}

absl::StatusOr<std::optional<NewRecords>> ReadNew(const Controller& controller,
                                                  const ProcessModel& model,
                                                  const Watch& watch) {
  MLE_ASSIGN_OR_RETURN(const double seconds_per_unit, SecondsOf(model));
  MLE_ASSIGN_OR_RETURN(HistorianOptions options,
                       ImportOptionsOf(controller, model));
  if (watch.sample_time > 0.0) options.sample_time = watch.sample_time;
  if (IsDatabase(controller.records)) {
    return ReadNewRows(controller, model, watch, std::move(options),
                       seconds_per_unit);
  }
  return NewFiles(controller, model, watch, std::move(options),
                  seconds_per_unit)
      .Read();
}

}  // namespace mle::watch
