#include "mle/data/historian.h"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/historian_importer.h"
#include "mle/data/joined_files.h"

namespace mle {
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
  MLE_ASSIGN_OR_RETURN(const std::optional<JoinedFiles> joined,
                       JoinFiles(sources, channels, options));
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
  return absl::InvalidArgumentError(
      absl::StrCat(name, ": ", CsvLineName(2, is_table),
                   ", column 1: no two samples follow each other without a "
                   "gap longer than max_gap"));
}

absl::StatusOr<HistorianImport> ImportHistorian(
    const std::vector<std::string>& paths, const ProcessModel& channels,
    const HistorianOptions& options) {
  std::vector<HistorianSource> sources;
  for (const std::string& path : paths) sources.push_back(FileSource(path));
  return ImportHistorianSources(sources, channels, options);
}

}  // namespace mle
