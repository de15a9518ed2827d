#include "apps/watch/source.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/tag_file.h"

namespace mle::watch {
namespace {

namespace fs = std::filesystem;

// Longer than ModelWatch::lead().
constexpr double kSettlingTimes = 3.0;

bool IsExport(const std::string& name) {
  return absl::EndsWith(name, ".csv") || absl::EndsWith(name, ".txt") ||
         absl::EndsWith(name, ".csv.gz") || absl::EndsWith(name, ".txt.gz");
}

absl::Status WrongFolder(const std::string& folder,
                         const std::error_code& error) {
  return absl::InvalidArgumentError(
      absl::StrCat("records: ", folder, ": ", error.message(),
                   "; it must be a folder of CSV files"));
}

absl::StatusOr<double> SecondsOf(const ProcessModel& model) {
  const std::optional<double> seconds = SecondsPerUnit(model.time_unit());
  if (seconds.has_value()) return *seconds;
  return absl::InvalidArgumentError(
      absl::StrCat("model: its time unit is \"", model.time_unit(),
                   "\"; s, min, h or d is needed to tell days"));
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

// As dated records, and the times of each file.
absl::StatusOr<DatedRecords> WithDates(
    HistorianImport import, double seconds_per_unit,
    std::map<std::string, std::pair<double, double>>& times) {
  if (!import.report.time_origin.has_value()) {
    return absl::InvalidArgumentError(
        "records: times are numbers without dates; a watch needs dates (such "
        "as 2024-02-29 12:34) to tell days");
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

}  // namespace

absl::StatusOr<HistorianOptions> ImportOptionsOf(const Controller& controller,
                                                 const ProcessModel& model) {
  HistorianOptions options;
  options.sample_time = controller.sample_time;
  options.clock.time_zone = controller.time_zone;
  options.columns.ignore_other_columns = true;
  options.any_word_is_bad = true;
  options.skip_repeated_times = true;
  if (!controller.tag_file.empty()) {
    MLE_ASSIGN_OR_RETURN(options.columns.tags,
                         ReadTagFile(controller.tag_file, model));
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

std::vector<std::string> FilesBetween(const Watch& watch, double from,
                                      double to) {
  std::vector<std::string> paths;
  for (const auto& [path, file] : watch.files) {
    if (file.fault.empty() && file.last >= from && file.first <= to &&
        fs::exists(path)) {
      paths.push_back(path);
    }
  }
  return paths;
}

absl::StatusOr<std::optional<NewRecords>> ReadNew(const Controller& controller,
                                                  const ProcessModel& model,
                                                  const Watch& watch) {
  MLE_ASSIGN_OR_RETURN(const double seconds_per_unit, SecondsOf(model));
  MLE_ASSIGN_OR_RETURN(HistorianOptions options,
                       ImportOptionsOf(controller, model));
  if (watch.sample_time > 0.0) options.sample_time = watch.sample_time;
  MLE_ASSIGN_OR_RETURN(const auto listed, ListFiles(controller.records));
  NewRecords result;
  std::vector<std::string> paths;
  for (const auto& [path, file] : listed) {
    const auto seen = watch.files.find(path);
    if (seen != watch.files.end() && seen->second.bytes == file.bytes &&
        seen->second.changed == file.changed) {
      continue;
    }
    result.files[path] = file;
    paths.push_back(path);
  }
  if (paths.empty()) return std::nullopt;
  std::map<std::string, std::string> faults;
  std::map<std::string, std::pair<double, double>> times;
  absl::StatusOr<HistorianImport> import =
      ImportReadable(paths, model, options, faults);
  if (import.ok()) {
    MLE_ASSIGN_OR_RETURN(
        result.data, WithDates(*std::move(import), seconds_per_unit, times));
  } else if (faults.size() != paths.size()) {
    return import.status();
  }
  result.first = std::numeric_limits<double>::infinity();
  result.last = -result.first;
  for (auto& [path, file] : result.files) {
    if (const auto found = times.find(path); found != times.end()) {
      file.first = found->second.first;
      file.last = found->second.second;
      result.first = std::min(result.first, file.first);
      result.last = std::max(result.last, file.last);
    } else {
      file.fault = faults[path];
      result.faults.push_back(
          absl::StrCat(path, " cannot be read: ", file.fault));
    }
  }
  if (result.data.records.empty()) return result;
  // What was read before and acts on what is new, or fills its days up.
  std::vector<std::string> all = paths;
  const double around =
      kSecondsOfDay + kSettlingTimes * SettlingTime(model) * seconds_per_unit;
  for (const std::string& path :
       FilesBetween(watch, result.first - around, result.last + around)) {
    if (!result.files.contains(path)) all.push_back(path);
  }
  if (all.size() > paths.size()) {
    MLE_ASSIGN_OR_RETURN(HistorianImport together,
                         ImportHistorian(all, model, options));
    MLE_ASSIGN_OR_RETURN(
        result.data, WithDates(std::move(together), seconds_per_unit, times));
  }
  return result;
}

}  // namespace mle::watch
