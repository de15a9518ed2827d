// mle_study: many runs of the experiment over a grid, on one machine or many.

#include <algorithm>
#include <iostream>
#include <string>

#include "absl/strings/str_join.h"
#include "apps/common/command_line.h"
#include "apps/common/option_table.h"
#include "apps/common/part.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/report.h"
#include "apps/experiment/study.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using experiment::Campaign;
using experiment::Grid;

struct Request {
  std::string campaign;  // a file
  std::string out = "study";
  Part part;
  bool resume = false;
  bool dry_run = false;
  bool figures = true;
  int threads = 0;  // 0: as many as there are processors for this process

  absl::Status Validate() const;
};

absl::Status Request::Validate() const {
  if (campaign.empty()) {
    return absl::InvalidArgumentError(
        "--campaign: the campaign's file is needed, as in "
        "--campaign=configs/campaign_reproduction.json");
  }
  if (out.empty()) {
    return absl::InvalidArgumentError("--out: a folder is needed");
  }
  return absl::OkStatus();
}

void AddOptions(Request& request, OptionTable& table) {
  table.Add(
      "Campaign",
      {{"campaign", &request.campaign,
        "The campaign (JSON): a grid of seeds, plants, mismatches, noise, "
        "controllers, set-point changes and estimators; "
        "configs/campaign_*.json are examples."},
       {"out", &request.out,
        "Folder for journal.csv, runs.csv, timings.csv, summary.csv, "
        "summary.json and report.html."},
       {"part", PartOfWork(&request.part),
        "Part of the runs, such as 3/16: the third of 16. Its journal is in "
        "parts/3-of-16 below --out. A run without --part takes over what parts "
        "have done, does what is left, and writes the results. Empty: all."},
       {"resume", &request.resume,
        "Resume the campaign in --out, if there is one. It must be the same "
        "campaign and version."},
       {"dry_run", &request.dry_run,
        "Only print how many runs there are, and the first few."},
       {"figures", &request.figures,
        "Draw the figures of the report (PNG and PDF need rsvg-convert)."},
       {"threads", &request.threads,
        "Threads; 0: one for each processor. The results do not depend on the "
        "number.",
        "", kNotNegative}});
  table.PutFirst(
      {"campaign", "out", "part", "resume", "dry_run", "figures", "threads"});
}

constexpr char kUsage[] =
    R"(Runs a campaign: the experiment of mle_reproduce over a grid of seeds, plants,
mismatches, noise, controllers, set-point changes and ways to estimate.

  mle_study --campaign=configs/campaign_reproduction.json --out=study
  mle_study --campaign=campaign.json --out=study --resume

An interrupted campaign resumes with --resume; only the runs that were in
progress are lost, and no run is repeated. Parts may run at once, on several
machines that see the folder; the run without --part brings them together:

  mle_study --campaign=campaign.json --out=study --part=1/2
  mle_study --campaign=campaign.json --out=study --part=2/2
  mle_study --campaign=campaign.json --out=study

Exit codes: 0 done, 1 stopped before the end or no run succeeded, 2 bad input or
flags.)";

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

// Summarises and reports; gives the exit code.
absl::StatusOr<int> Conclude(const Request& request,
                             const experiment::Study& work,
                             const experiment::RunFolder& folder) {
  MLE_ASSIGN_OR_RETURN(
      const experiment::StudySummary summary,
      experiment::Conclude(work, folder, request.figures,
                           HowToRunAgain(work.campaign.seeds)));
  experiment::PrintSummary(work.campaign, summary);
  std::cout << "Report and results: " << request.out << "/report.html\n";
  for (const auto& [kind, count] : summary.failures) {
    std::cerr << "warning: " << count << " of " << summary.runs
              << " runs: " << kind << "\n";
  }
  return summary.failed < summary.runs ? kExitDone : kExitNotUsable;
}

absl::StatusOr<experiment::Study> ReadCampaign(const Request& request) {
  MLE_ASSIGN_OR_RETURN(const std::string text,
                       AboutOption("campaign", ReadFile(request.campaign)));
  const std::size_t slash = request.campaign.rfind('/');
  const std::string folder =
      slash == std::string::npos ? "" : request.campaign.substr(0, slash + 1);
  return experiment::ReadStudy(text, request.campaign, folder);
}

absl::StatusOr<int> Run(Request& request, OptionTable& /*table*/) {
  MLE_RETURN_IF_ERROR(request.Validate());
  MLE_ASSIGN_OR_RETURN(const experiment::Study work, ReadCampaign(request));
  if (request.dry_run) {
    PrintPlan(work.campaign, Grid(work.campaign));
    return kExitDone;
  }
  const experiment::Work runs = WorkOf(work);
  MLE_ASSIGN_OR_RETURN(experiment::RunFolder folder,
                       experiment::OpenFolder(work, runs, request.out,
                                              request.part, request.resume));
  MLE_ASSIGN_OR_RETURN(
      const bool whole,
      folder.RunAsCommand(runs, "runs", "with --resume ", request.threads));
  if (whole) return Conclude(request, work, folder);
  return folder.is_done() ? kExitDone : kExitNotUsable;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  return mle::RunCommand(mle::kUsage, mle::AddOptions, mle::Run, argc, argv);
}
