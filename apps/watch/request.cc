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
        "What was seen and found is remembered here: an SQLite file, or "
        "postgresql://USER@HOST/NAME; empty: state.sqlite in --out."},
       {"alarm_command", &request.alarm_command,
        "Program that is run for each alarm, with its id as argument and the "
        "alarm as JSON on its standard input; empty: none. What it ends with "
        "another exit code than 0 for is handed on again by the next run."},
       {"propose", &request.propose,
        "Runs a correction where a model has aged, as mle_correct does, and "
        "keeps its results below --out."},
       {"shard", &request.shard_text,
        "Part of the controllers that this run looks at, such as 3/16: the "
        "third of 16, told by their names. Its pages are in shards/3-of-16 "
        "below --out. With a state in PostgreSQL a run without --shard makes "
        "the pages of all and hands on alarms. Empty: all."},
       {"update", &request.update,
        "Looks at records; if not, pages and alarms are of what is in the "
        "state."},
       {"threads", &request.threads,
        "Threads; 0: one for each processor. The results do not depend on the "
        "number.",
        "", kNotNegative}});
  table.PutFirst({"controllers", "out", "state", "alarm_command", "propose",
                  "shard", "update", "threads"});
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
  absl::StatusOr<Shard> shard = ParseShard(request.shard_text);
  if (!shard.ok()) return AboutOption("shard", shard.status());
  request.shard = *std::move(shard);
  if (!request.shard.is_everything()) {
    std::erase_if(request.controllers,
                  [&request](const Controller& controller) {
                    return !request.shard.Has(controller.name);
                  });
    absl::StrAppend(&request.out, "/shards/", request.shard.Name());
  }
  if (request.state.empty()) {
    request.state = absl::StrCat(request.out, "/state.sqlite");
  }
  request.threads = UsableThreads(request.threads);
  return absl::OkStatus();
}

}  // namespace mle::watch
