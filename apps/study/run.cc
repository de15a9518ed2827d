#include "apps/study/run.h"

#include <sched.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/sha256.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/row.h"
#include "apps/study/merge.h"
#include "apps/study/outputs.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::study {

using experiment::Grid;

absl::StatusOr<Study> ReadStudy(std::string_view text,
                                const std::string& source,
                                const std::string& folder) {
  Study study;
  MLE_ASSIGN_OR_RETURN(study.resolved, ResolveCampaign(text, source, folder));
  MLE_ASSIGN_OR_RETURN(study.campaign, ParseCampaign(study.resolved, source));
  return study;
}

absl::StatusOr<StudyFolder> OpenFolder(const Study& study,
                                       const std::string& path, bool resume) {
  MLE_ASSIGN_OR_RETURN(FolderLock lock, ClaimOutputFolder(path));
  const std::string checksum = Sha256Of(study.resolved);
  if (checksum.empty()) {
    return absl::InternalError("the campaign's checksum cannot be computed");
  }
  const Grid grid(study.campaign);
  MLE_ASSIGN_OR_RETURN(std::unique_ptr<Journal> journal,
                       Journal::Open(
                           absl::StrCat(path, "/journal.csv"),
                           {.checksum = checksum,
                            .version = std::string(Version()),
                            .runs = grid.num_runs()},
                           [&](std::int64_t run) {
                             return experiment::RowStart(study.campaign, grid,
                                                         run);
                           },
                           resume));
  MLE_RETURN_IF_ERROR(WriteFileAtomically(absl::StrCat(path, "/campaign.json"),
                                          study.resolved));
  return StudyFolder{path, std::move(lock), std::move(journal)};
}

int StudyThreads(int wanted, int processes) {
  if (wanted > 0) return UsableThreads(wanted);
  const int all =
      std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
  cpu_set_t set;
  CPU_ZERO(&set);
  const int allowed = sched_getaffinity(0, sizeof(set), &set) == 0
                          ? std::max(CPU_COUNT(&set), 1)
                          : all;
  if (allowed < all) return allowed;
  return std::max(all / processes, 1);
}

absl::StatusOr<StudySummary> Conclude(const Study& study,
                                      const StudyFolder& folder, bool figures,
                                      const report::RunAgain& run_again) {
  const Grid grid(study.campaign);
  MLE_RETURN_IF_ERROR(MergeRuns(*folder.journal, grid.num_runs(), folder.path));
  MLE_ASSIGN_OR_RETURN(
      StudySummary summary,
      Summarise(absl::StrCat(folder.path, "/runs.csv"), study.campaign, grid));
  MLE_RETURN_IF_ERROR(
      WriteOutputs(folder.path, figures, study.campaign, summary, run_again));
  return summary;
}

}  // namespace mle::study
