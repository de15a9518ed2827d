#include "apps/watch/request.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/model_files.h"
#include "mle/base/status.h"

namespace mle::watch {

void AddOptions(Request& request, OptionTable& table) {
  table.Add(
      "Files",
      {{"controllers", &request.watch_path,
        "File (JSON) that lists the controllers, their models and the folders "
        "of their records (docs/formats.md); must be given."},
       {"out", &request.out,
        "Folder for the pages (index.html and one for each controller), "
        "watch.json and the corrections that are proposed."},
       {"state", &request.state,
        "SQLite file that remembers what was seen and found; empty: "
        "state.sqlite in --out."},
       {"alarm_command", &request.alarm_command,
        "Program that is run for each alarm, with its id as argument and the "
        "alarm as JSON on its standard input; empty: none. What it ends with "
        "another exit code than 0 for is handed on again by the next run."},
       {"propose", &request.propose,
        "Runs a correction where a model has aged, as mle_correct does, and "
        "keeps its results below --out."},
       {"threads", &request.threads,
        "Threads; 0: one for each processor. The results do not depend on the "
        "number.",
        "", kNotNegative}});
  table.PutFirst(
      {"controllers", "out", "state", "alarm_command", "propose", "threads"});
}

absl::Status Complete(Request& request) {
  if (request.watch_path.empty()) {
    return absl::InvalidArgumentError(
        "--controllers=FILE.json must be given (see --help)");
  }
  absl::StatusOr<std::vector<Controller>> controllers =
      ReadWatchFile(request.watch_path);
  if (!controllers.ok())
    return AboutOption("controllers", controllers.status());
  request.controllers = *std::move(controllers);
  if (request.state.empty()) {
    request.state = absl::StrCat(request.out, "/state.sqlite");
  }
  request.threads = UsableThreads(request.threads);
  return absl::OkStatus();
}

}  // namespace mle::watch
