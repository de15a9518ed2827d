#include "apps/watch/request.h"

#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

void AddAlarmOptions(Request& request, OptionTable& table) {
  table.Add(
      "Alarms",
      {{"alarm_command", &request.alarms.command,
        "Program that is run for each alarm, with its id as argument and the "
        "alarm as JSON on its standard input; empty: none. What it ends with "
        "another exit code than 0 for is handed on again by the next run."},
       {"alarm_mail", Words(&request.alarms.mail_addresses),
        "Addresses that each alarm is mailed to, separated by commas; empty: "
        "none."},
       {"sendmail", &request.alarms.sendmail,
        "Program that takes mails, as sendmail does, with the addresses as "
        "arguments."},
       {"alarm_webhook", &request.alarms.webhook,
        "Address (http:// or https://) that each alarm is sent to as JSON, by "
        "POST; empty: that in the environment variable MLE_WATCH_WEBHOOK, or "
        "none. A status of 200 to 299 takes the alarm."}});
}

void AddServerOptions(Request& request, OptionTable& table) {
  table.Add(
      "Server",
      {{"serve", &request.serve,
        "Serves pages, metrics (/metrics) and JSON (/api/v1) at this address, "
        "such as 127.0.0.1:8080 or 8080 for it, until it is stopped; in place "
        "of a run. Empty: no server."},
       {"host_names", Words(&request.host_names),
        "Names that the server is known by, besides localhost and addresses in "
        "numbers, separated by commas: behind a proxy, for example. Requests "
        "to other names are refused."},
       {"token_file", &request.token_file,
        "File with the token that acknowledging alarms takes; empty: that in "
        "the environment variable MLE_WATCH_TOKEN. Without a token the server "
        "is read-only."}});
  table.Add("Acknowledgement",
            {{"acknowledge", &request.acknowledge,
              "Id of an alarm, or its beginning, that is acknowledged; in "
              "place of a run."},
             {"acknowledged_by", &request.acknowledged_by,
              "Who acknowledges it; empty: the user."},
             {"note", &request.note, "What is kept with it."}});
}

void SetState(Request& request) {
  if (request.state.empty()) {
    request.state = absl::StrCat(request.out, "/state.sqlite");
  }
}

// Address of the server.
absl::Status CompleteServer(Request& request) {
  if (request.serve.empty()) return absl::OkStatus();
  if (!request.part.is_everything()) {
    return absl::InvalidArgumentError("--serve and --part exclude each other");
  }
  absl::StatusOr<serve::ServerOptions> address =
      serve::ParseAddress(request.serve);
  if (!address.ok()) {
    return RefuseOption("serve", request.serve,
                        std::string(address.status().message()));
  }
  request.address = *std::move(address);
  return absl::OkStatus();
}

}  // namespace

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
       {"propose", &request.propose,
        "Runs a correction where a model has aged, as mle_correct does, and "
        "keeps its results below --out."},
       {"part", PartOfWork(&request.part),
        "Part of the controllers that this run looks at, such as 3/16: the "
        "third of 16, told by their names. Its pages are in parts/3-of-16 "
        "below --out. With a state in PostgreSQL a run without --part makes "
        "the pages of all and hands on alarms. Empty: all."},
       {"update", &request.update,
        "Looks at records; if not, pages and alarms are of what is in the "
        "state."},
       {"threads", &request.threads,
        "Threads; 0: one for each processor. The results do not depend on the "
        "number.",
        "", kNotNegative}});
  AddAlarmOptions(request, table);
  AddServerOptions(request, table);
  table.PutFirst({"controllers", "out", "state", "alarm_command", "propose",
                  "serve", "acknowledge"});
}

absl::Status Complete(Request& request) {
  if (!request.acknowledge.empty()) {
    SetState(request);
    return request.serve.empty()
               ? absl::OkStatus()
               : absl::InvalidArgumentError(
                     "--acknowledge and --serve exclude each other");
  }
  if (request.watch_path.empty()) {
    return absl::InvalidArgumentError(
        "--controllers=FILE.json must be given (see --help)");
  }
  MLE_ASSIGN_OR_RETURN(
      request.controllers,
      AboutOption("controllers", ReadWatchFile(request.watch_path)));
  std::erase_if(request.controllers, [&request](const Controller& controller) {
    return !request.part.Has(controller.name);
  });
  request.out = request.part.FolderBelow(request.out);
  SetState(request);
  MLE_RETURN_IF_ERROR(CompleteServer(request));
  const char* const webhook = std::getenv(kWebhookVariable);
  if (request.alarms.webhook.empty() && webhook != nullptr) {
    request.alarms.webhook = webhook;
  }
  request.threads = UsableThreads(request.threads);
  return CheckTargets(request.alarms);
}

}  // namespace mle::watch
