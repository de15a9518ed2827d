// mle_study: many runs of the experiment over a grid, on one machine or many.

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/command_line.h"
#include "apps/common/progress.h"
#include "apps/common/run_again.h"
#include "apps/common/stop_signal.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/row.h"
#include "apps/study/campaign.h"
#include "apps/study/coordinator.h"
#include "apps/study/journal.h"
#include "apps/study/outputs.h"
#include "apps/study/processes.h"
#include "apps/study/request.h"
#include "apps/study/run.h"
#include "apps/study/summary.h"
#include "apps/study/worker_pool.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using experiment::Campaign;
using experiment::Grid;
using study::Journal;
using study::Processes;

constexpr char kUsage[] =
    R"(Runs a campaign: the experiment of mle_reproduce over a grid of seeds, plants,
mismatches, noise, controllers, set-point changes and ways to estimate.

  mle_study --campaign=configs/campaign_reproduction.json --out=study
  mle_study --campaign=campaign.json --out=study --resume

An interrupted campaign resumes with --resume; only the runs that were in
progress are lost, and no run is repeated. )";

constexpr char kUsageMpi[] = R"(On several processors or
machines, of which the first writes the results:

  mpirun -np 4 mle_study --campaign=campaign.json --out=study)";

constexpr char kUsageNoMpi[] = R"(This program was built
without MPI: it runs on the threads of one machine. Built where MPI is found
(libopenmpi-dev on Debian) it also runs as mpirun -np K mle_study ….)";

constexpr char kUsageEnd[] = R"(

Exit codes: 0 done, 1 stopped before the end or no run succeeded, 2 bad input or
flags.)";

int Threads(const study::Request& request, const Processes& processes) {
  return study::StudyThreads(request.threads, processes.on_this_machine());
}

void PrintPlan(const Campaign& campaign, const Grid& grid) {
  constexpr std::int64_t kShown = 10;
  std::cout << "Campaign " << campaign.name << ": " << grid.num_runs()
            << " runs, " << grid.num_cells() << " cells of the grid with "
            << grid.seeds() << " seeds each, in " << grid.num_units()
            << " units of work.\n\n"
            << "run," << absl::StrJoin(experiment::CoordinateNames(), ",")
            << "\n";
  for (std::int64_t run = 0; run < std::min(kShown, grid.num_runs()); ++run) {
    std::cout << run << ","
              << absl::StrJoin(CoordinateTexts(campaign, grid.At(run)), ",")
              << "\n";
  }
  if (grid.num_runs() > kShown) std::cout << "…\n";
}

// What process 0 has open before the others may begin.
struct Prepared {
  study::Study work;
  std::optional<study::StudyFolder> folder;
};

// Merges, summarises and reports; gives the exit code.
absl::StatusOr<int> Conclude(const study::Request& request,
                             const Prepared& prepared) {
  const Campaign& campaign = prepared.work.campaign;
  MLE_ASSIGN_OR_RETURN(
      const study::StudySummary summary,
      study::Conclude(prepared.work, *prepared.folder, request.figures,
                      HowToRunAgain(campaign.seeds)));
  study::PrintSummary(campaign, summary);
  std::cout << "Report and results: " << request.out << "/report.html\n";
  for (const auto& [kind, count] : summary.failures) {
    std::cerr << "warning: " << count << " of " << summary.runs
              << " runs: " << kind << "\n";
  }
  return summary.failed < summary.runs ? kExitDone : kExitNotUsable;
}

absl::StatusOr<study::Study> ReadCampaign(const study::Request& request) {
  const absl::StatusOr<std::string> text = ReadFile(request.campaign);
  if (!text.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--campaign: ", text.status().message()));
  }
  const std::size_t slash = request.campaign.rfind('/');
  const std::string folder =
      slash == std::string::npos ? "" : request.campaign.substr(0, slash + 1);
  return study::ReadStudy(*text, request.campaign, folder);
}

// What was found in a journal that is resumed.
void PrintFound(const Journal& journal, std::int64_t runs) {
  constexpr std::size_t kShown = 5;
  if (journal.dropped_bytes() > 0) {
    std::cerr << "journal.csv: an incomplete last line is dropped ("
              << journal.dropped_bytes() << " bytes)\n";
  }
  const std::vector<std::int64_t>& damaged = journal.damaged_lines();
  for (std::size_t i = 0; i < std::min(damaged.size(), kShown); ++i) {
    std::cerr << "warning: journal.csv:" << damaged[i]
              << ": the line is damaged (its checksum or its coordinates are "
                 "wrong); its run is done again\n";
  }
  if (damaged.size() > kShown) {
    std::cerr << "warning: journal.csv: " << damaged.size() - kShown
              << " more lines are damaged\n";
  }
  if (journal.num_done() > 0) {
    std::cerr << "Going on: " << journal.num_done() << " of " << runs
              << " runs are done.\n";
  }
}

absl::Status OpenFolder(const study::Request& request, Prepared& prepared) {
  MLE_ASSIGN_OR_RETURN(
      prepared.folder,
      study::OpenFolder(prepared.work, request.out, request.resume));
  PrintFound(*prepared.folder->journal,
             Grid(prepared.work.campaign).num_runs());
  return absl::OkStatus();
}

absl::StatusOr<int> Run(const study::Request& request, const Prepared& prepared,
                        Processes& processes) {
  const Campaign& campaign = prepared.work.campaign;
  Journal& journal = *prepared.folder->journal;
  const Grid grid(campaign);
  CatchStopSignals();
  {
    study::WorkerPool pool(campaign, grid, Threads(request, processes));
    MLE_RETURN_IF_ERROR(Coordinate(grid, processes, pool, journal,
                                   StopRequested, ShowProgress("runs")));
  }
  if (journal.num_done() < grid.num_runs()) {
    std::cerr
        << "Stopped: " << journal.num_done() << " of " << grid.num_runs()
        << " runs are done, in " << request.out
        << "/journal.csv. Give the same command with --resume to resume.\n";
    return kExitNotUsable;
  }
  return Conclude(request, prepared);
}

// Process 0. The others wait for the campaign's text; an empty one means that
// there is nothing to do, none that there is an error.
absl::StatusOr<int> Lead(const study::Request& request, Processes& processes) {
  Prepared prepared;
  absl::StatusOr<study::Study> read = ReadCampaign(request);
  absl::Status status = read.status();
  if (status.ok()) prepared.work = *std::move(read);
  if (status.ok() && request.dry_run) {
    processes.Broadcast("");
    PrintPlan(prepared.work.campaign, Grid(prepared.work.campaign));
    return kExitDone;
  }
  if (status.ok()) status = OpenFolder(request, prepared);
  if (!status.ok()) {
    processes.Broadcast(std::nullopt);
    return status;
  }
  processes.Broadcast(prepared.work.resolved);
  return Run(request, prepared, processes);
}

int Follow(const study::Request& request, Processes& processes) {
  const std::optional<std::string> resolved = processes.Broadcast(std::nullopt);
  if (!resolved.has_value()) return kExitBadInput;  // The first has said why.
  if (resolved->empty()) return kExitDone;
  const absl::StatusOr<Campaign> campaign =
      study::ParseCampaign(*resolved, request.campaign);
  if (!campaign.ok()) return Fail(campaign.status());
  const Grid grid(*campaign);
  CatchStopSignals();
  study::WorkerPool pool(*campaign, grid, Threads(request, processes));
  Serve(processes, pool, StopRequested);
  return kExitDone;
}

int Main(const study::Request& request, int* argc, char*** argv) {
  const absl::StatusOr<std::unique_ptr<Processes>> processes =
      Processes::Start(argc, argv);
  if (!processes.ok()) return Fail(processes.status());
  const absl::Status valid = request.Validate();
  const bool leads = (*processes)->rank() == 0;
  if (!valid.ok()) return leads ? Fail(valid) : kExitBadInput;
  if (!leads) return Follow(request, **processes);
  const absl::StatusOr<int> code = Lead(request, **processes);
  return code.ok() ? *code : Fail(code.status());
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  mle::study::Request request;
  mle::OptionTable table;
  mle::study::AddOptions(request, table);
  mle::StartCommand(
      absl::StrCat(
          mle::kUsage,
          mle::study::Processes::HaveMpi() ? mle::kUsageMpi : mle::kUsageNoMpi,
          mle::kUsageEnd),
      table, argc, argv);
  return mle::Main(request, &argc, &argv);
}
