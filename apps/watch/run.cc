#include "apps/watch/run.h"

#include <filesystem>
#include <mutex>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/watch/alarms.h"
#include "apps/watch/page.h"
#include "apps/watch/proposal.h"
#include "apps/watch/report_json.h"
#include "apps/watch/update.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/database/record_sources.h"
#include "mle/exchange/model_file.h"

namespace mle::watch {
namespace {

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
  // What was there before stays, with word of what went wrong.
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

// Of the state's folder, unless that is locked with the pages'; a database has
// locks of its own.
absl::StatusOr<std::optional<FolderLock>> LockState(const Request& request) {
  if (IsDatabase(request.state)) return std::nullopt;
  fs::path folder = fs::path(request.state).parent_path();
  if (folder.empty()) folder = ".";
  MLE_RETURN_IF_ERROR(MakeWritableFolder(folder.string()));
  std::error_code error;
  if (fs::equivalent(folder, request.out, error)) return std::nullopt;
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder.string());
  if (!lock.ok()) return WithPrefix(lock.status(), "--state: ");
  return std::optional<FolderLock>(*std::move(lock));
}

}  // namespace

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
  // Of a state that is shared the run over all controllers hands on alarms, or
  // two parts would.
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

}  // namespace mle::watch
