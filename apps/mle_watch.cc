// mle_watch: the health of every model, every day.

#include <malloc.h>
#include <pwd.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/common/command_line.h"
#include "apps/common/process_faults.h"
#include "apps/serve/access.h"
#include "apps/serve/server.h"
#include "apps/watch/alarms.h"
#include "apps/watch/health.h"
#include "apps/watch/report.h"
#include "apps/watch/request.h"
#include "apps/watch/site.h"
#include "apps/watch/update.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/database/record_sources.h"
#include "mle/exchange/model_file.h"

namespace mle::watch {
namespace {

// A run of mle_watch over all controllers.

struct RunSummary {
  int controllers = 0;
  int aged = 0;
  // Sentences on all failures: a controller that could not be looked at, a
  // wrong list of controllers, an alarm that was not accepted.
  std::vector<std::string> failures = {};
};

// Who has started this program.
std::string UserName() {
  const passwd* const user = getpwuid(getuid());
  return user == nullptr ? "" : user->pw_name;
}

constexpr absl::Duration kTick = absl::Milliseconds(200);
constexpr int kTicksOfLook = 5;

std::string UrlOf(const serve::ServerOptions& options, int port) {
  const bool is_six = options.host.find(':') != std::string::npos;
  return absl::StrCat("http://", is_six ? "[" : "", options.host,
                      is_six ? "]" : "", ":", port, "/");
}

// Looks for news until it is to stop, and says on standard error what cannot be
// read. An error where the first reading fails.
absl::Status KeepUp(Site& site) {
  MLE_RETURN_IF_ERROR(site.Refresh(StopRequested));
  std::string said;
  for (int tick = 1; !StopRequested(); ++tick) {
    absl::SleepFor(kTick);
    if (tick % kTicksOfLook != 0) continue;
    MLE_RETURN_IF_ERROR(site.Refresh(StopRequested));
    const std::string fault = site.snapshot()->fault;
    if (fault != said && !fault.empty()) {
      SayError(absl::StrCat(fault, " (showing what was read before)"));
    }
    said = fault;
  }
  return absl::OkStatus();
}

namespace fs = std::filesystem;

// One controller after a run.
struct Outcome {
  ProcessModel model;
  Watch watch;
  absl::Status status;
};

class Runner {
 public:
  Runner(const Request& request, State& state)
      : request_(request), state_(state) {}

  Outcome Run(const Controller& controller);

 private:
  absl::Status Update(const Controller& controller, Outcome& outcome);
  absl::StatusOr<Watch> Load(const Controller& controller,
                             const ProcessModel& model) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return state_.Load(controller.name, model.num_outputs());
  }
  absl::Status Save(Watch& watch) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return state_.Save(watch);
  }

  const Request& request_;
  State& state_;
  std::mutex mutex_;
};

absl::Status Runner::Update(const Controller& controller, Outcome& outcome) {
  absl::StatusOr<ModelFile> file = ReadModelFile(controller.model);
  if (!file.ok()) return WithPrefix(file.status(), "model: ");
  outcome.model = file->process;
  MLE_ASSIGN_OR_RETURN(outcome.watch, Load(controller, outcome.model));
  if (!request_.update) return absl::OkStatus();
  outcome.watch.failed = false;
  MLE_RETURN_IF_ERROR(UpdateWatch(controller, outcome.model, outcome.watch));
  // Alarms are in the state before the correction, which may take long.
  MLE_RETURN_IF_ERROR(Save(outcome.watch));
  if (!request_.propose || !NeedsProposal(outcome.watch)) {
    return absl::OkStatus();
  }
  MakeProposal(controller, *file, absl::StrCat(request_.out, "/proposals"),
               outcome.watch);
  return Save(outcome.watch);
}

Outcome Runner::Run(const Controller& controller) {
  Outcome outcome;
  outcome.status = Update(controller, outcome);
  if (outcome.status.ok()) return outcome;
  // The watch stays as it was, with a sentence on the failure.
  absl::StatusOr<Watch> before = Load(controller, outcome.model);
  if (!before.ok()) {
    outcome.watch = EmptyWatch(controller.name, outcome.model.num_outputs());
    return outcome;
  }
  outcome.watch = *std::move(before);
  outcome.watch.failed = true;
  outcome.watch.news = std::string(outcome.status.message());
  // The failure itself is what is reported.
  Save(outcome.watch).IgnoreError();
  return outcome;
}

absl::Status WritePages(const Request& request,
                        const std::vector<Report>& reports) {
  std::vector<std::pair<std::string, std::string>> files = {
      {"watch.json", FormatReports(reports)},
      {kOverviewPage, FormatOverview(reports)},
      {kAlarmsPage, FormatAlarmsPage(reports)}};
  for (const Report& report : reports) {
    files.emplace_back(PageName(report),
                       FormatControllerPage(report, request.out));
  }
  return WriteFilesTogether(request.out, files);
}

// Of a state that is a file.
std::string StateFolder(const Request& request) {
  const fs::path folder = fs::path(request.state).parent_path();
  return folder.empty() ? "." : folder.string();
}

// Locks the state's folder, unless it is the folder of the pages, which has its
// lock already; a database has locks of its own.
absl::StatusOr<std::optional<FolderLock>> LockState(const Request& request) {
  if (IsDatabase(request.state)) return std::nullopt;
  const std::string folder = StateFolder(request);
  MLE_RETURN_IF_ERROR(MakeWritableFolder(folder));
  std::error_code error;
  if (fs::equivalent(folder, request.out, error)) return std::nullopt;
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder);
  if (!lock.ok()) return WithPrefix(lock.status(), "--state: ");
  return std::optional<FolderLock>(*std::move(lock));
}

// Brings the state up to date, hands on alarms and writes the pages. A
// controller whose records or model are broken stops no other. Errors are of
// the state and the folder. Unavailable where another run is at work.
absl::StatusOr<RunSummary> RunWatches(const Request& request) {
  MLE_ASSIGN_OR_RETURN(const FolderLock lock, ClaimOutputFolder(request.out));
  MLE_ASSIGN_OR_RETURN(const std::optional<FolderLock> state_lock,
                       LockState(request));
  MLE_ASSIGN_OR_RETURN(State state, State::Open(request.state));
  MLE_RETURN_IF_ERROR(state.Claim(request.part.text));
  Runner runner(request, state);
  const auto count = static_cast<int>(request.controllers.size());
  std::vector<Outcome> outcomes(request.controllers.size());
  ParallelFor(count, request.threads,
              [&](int i) { outcomes[i] = runner.Run(request.controllers[i]); });
  RunSummary summary{.controllers = count};
  // With a shared state only the run over all controllers hands on alarms, so
  // that no two parts hand on the same one.
  std::vector<std::string> not_taken;
  if (request.part.is_everything() || !IsDatabase(request.state)) {
    MLE_ASSIGN_OR_RETURN(not_taken, HandOnAlarms(request.alarms, state));
  }
  for (Outcome& outcome : outcomes) {
    if (!outcome.watch.alarms.empty()) {
      MLE_RETURN_IF_ERROR(state.ReloadAlarms(outcome.watch));
    }
  }
  std::vector<Report> reports(outcomes.size());
  ParallelFor(count, request.threads, [&](int i) {
    reports[i] = MakeReport(request.controllers[i], outcomes[i].model,
                            outcomes[i].watch);
  });
  for (int i = 0; i < count; ++i) {
    const Outcome& outcome = outcomes[i];
    Report& report = reports[i];
    if (!outcome.status.ok()) {
      report.status = Status::kFailed;
      report.sentence = std::string(outcome.status.message());
      summary.failures.push_back(
          absl::StrCat(report.name, ": ", report.sentence));
    }
    if (report.cost.wrong_list) summary.failures.push_back(report.cost.reason);
    summary.aged += report.status == Status::kAged ? 1 : 0;
  }
  summary.failures.insert(summary.failures.end(), not_taken.begin(),
                          not_taken.end());
  MLE_RETURN_IF_ERROR(WritePages(request, reports));
  return summary;
}

// Does what --serve asks for: serves until SIGINT, SIGTERM or SIGHUP; then
// answers the requests that have come and returns. Errors are about the state,
// the list of controllers, the token and the address.
absl::Status ServeSite(const Request& request) {
  // Otherwise each thread keeps what it needed for its largest page.
  mallopt(M_ARENA_MAX, 2);
  absl::StatusOr<std::string> token =
      serve::ReadToken(request.token_file, kTokenVariable);
  if (!token.ok()) {
    return request.token_file.empty()
               ? token.status()
               : WithPrefix(token.status(), "--token_file: ");
  }
  const serve::Access access = {.host_names = request.host_names,
                                .token = *std::move(token)};
  // SQLite needs files beside the state's; of the pages nothing is written.
  if (!IsDatabase(request.state)) {
    MLE_RETURN_IF_ERROR(MakeWritableFolder(StateFolder(request)));
  }
  MLE_ASSIGN_OR_RETURN(const std::unique_ptr<Site> site,
                       Site::Open({.list = request.watch_path,
                                   .state = request.state,
                                   .folder = request.out,
                                   .can_acknowledge = !access.token.empty(),
                                   .threads = request.threads}));
  CatchStopSignals();
  absl::StatusOr<std::unique_ptr<serve::Server>> server =
      serve::Server::Start(request.address, [&](const serve::Request& asked) {
        return Answer(*site, access, asked);
      });
  if (!server.ok()) return WithPrefix(server.status(), "--serve: ");
  std::cout << "serving " << UrlOf(request.address, (*server)->port())
            << (access.token.empty() ? " (read-only)" : "") << std::endl;
  if (!serve::IsLoopback(request.address.host)) {
    std::cerr << "note: other machines can reach this address, and nothing is "
                 "encrypted; docs/watch.md shows a proxy that encrypts\n";
  }
  const absl::Status status = KeepUp(*site);
  (*server)->Stop();
  return status;
}

// Does what --acknowledge asks for; says on standard output what was done.
absl::Status AcknowledgeAlarm(const Request& request) {
  std::error_code error;
  if (!IsDatabase(request.state) &&
      !std::filesystem::exists(request.state, error)) {
    return InvalidArgument("--state: there is no ", request.state);
  }
  MLE_ASSIGN_OR_RETURN(const Acknowledgement made,
                       MakeAcknowledgement(request.acknowledged_by.empty()
                                               ? UserName()
                                               : request.acknowledged_by,
                                           request.note));
  MLE_ASSIGN_OR_RETURN(State state, State::Open(request.state));
  const absl::StatusOr<std::string> id = state.FindAlarm(request.acknowledge);
  if (!id.ok()) return WithPrefix(id.status(), "--acknowledge: ");
  MLE_RETURN_IF_ERROR(state.Acknowledge(*id, made));
  std::cout << "alarm " << *id << " acknowledged by " << made.who << "\n";
  return absl::OkStatus();
}

constexpr char kUsage[] =
    R"(Watches the models of controllers: reads what is new in their records, carries
on the evidence that a gain, a time constant or a dead time has changed, raises
alarms, runs corrections, and writes pages. To be run every day, by cron or a
systemd timer; a run that was missed is caught up, a run twice changes nothing.

  mle_watch --controllers=controllers.json --out=watch

Serves the pages, until it is stopped:

  mle_watch --controllers=controllers.json --out=watch --serve=127.0.0.1:8080

Acknowledges an alarm:

  mle_watch --out=watch --acknowledge=3f9a12c0 --note="valve ordered"

It never writes to a controller. Exit codes: 0 done, whatever was found; 1 a
controller could not be looked at, or an alarm not handed on; 2 bad input or
flags.)";

absl::StatusOr<int> Run(Request& request, OptionTable& /*table*/) {
  MLE_RETURN_IF_ERROR(Complete(request));
  if (!request.acknowledge.empty() || !request.serve.empty()) {
    MLE_RETURN_IF_ERROR(request.acknowledge.empty()
                            ? ServeSite(request)
                            : AcknowledgeAlarm(request));
    return kExitDone;
  }
  MLE_ASSIGN_OR_RETURN(const RunSummary summary, RunWatches(request));
  std::cout << summary.aged << " of " << summary.controllers
            << " models have aged; see " << request.out << "/index.html\n";
  for (const std::string& failure : summary.failures) SayError(failure);
  return summary.failures.empty() ? kExitDone : kExitNotUsable;
}

}  // namespace
}  // namespace mle::watch

int main(int argc, char** argv) {
  return mle::RunCommand(mle::watch::kUsage, mle::watch::AddOptions,
                         mle::watch::Run, argc, argv);
}
