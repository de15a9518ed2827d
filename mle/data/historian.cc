#include "mle/data/historian.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/historian_importer.h"

namespace mle {

absl::StatusOr<HistorianImport> ImportHistorianSources(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate(channels));
  MLE_ASSIGN_OR_RETURN(HistorianScan scan,
                       HistorianImporter(channels, options).Run(sources, -1.0));
  HistorianImport import{std::move(scan.records), std::move(scan.report)};
  if (!import.records.empty()) return import;
  const std::string& name = import.report.files[0].name;
  if (!options.keep.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": no samples lie within the times to be kept"));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      name,
      ": line 2, column 1: no two samples follow each other without a "
      "gap longer than max_gap"));
}

absl::StatusOr<HistorianImport> ImportAroundChanges(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options, double before, double after,
    double min_change) {
  MLE_RETURN_IF_ERROR(options.Validate(channels));
  for (const double value : {before, after, min_change}) {
    if (value >= 0.0 && std::isfinite(value)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("historian: before is ", before, ", after ", after,
                     ", min_change ", min_change, "; none may be negative"));
  }
  MLE_ASSIGN_OR_RETURN(
      const HistorianScan scan,
      HistorianImporter(channels, options).Run(sources, min_change));
  HistorianOptions around = options;
  around.keep.clear();
  for (const double time : scan.change_times) {
    const TimeRange range{time - before, time + after};
    if (around.keep.empty() || around.keep.back().to < range.from) {
      around.keep.push_back(range);
    } else {
      around.keep.back().to = range.to;
    }
  }
  if (around.keep.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(scan.report.files[0].name,
                     ": no set point changes in any row; columns "
                     "<output>_setpoint must hold changes"));
  }
  return ImportHistorianSources(sources, channels, around);
}

absl::StatusOr<HistorianImport> ImportHistorian(
    const std::vector<std::string>& paths, const ProcessModel& channels,
    const HistorianOptions& options) {
  std::vector<HistorianSource> sources;
  for (const std::string& path : paths) sources.push_back(FileSource(path));
  return ImportHistorianSources(sources, channels, options);
}

}  // namespace mle
