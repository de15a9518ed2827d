#include "apps/study/run.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/sha256.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/row.h"
#include "apps/experiment/unit.h"
#include "apps/study/journal.h"
#include "apps/study/report.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

using experiment::Campaign;
using experiment::Grid;

// Between two looks at signals.
constexpr std::chrono::milliseconds kPause(100);

absl::StatusOr<std::unique_ptr<Journal>> OpenJournal(const Study& study,
                                                     const std::string& folder,
                                                     bool resume) {
  const std::string checksum = Sha256Of(study.resolved);
  if (checksum.empty()) {
    return absl::InternalError("the campaign's checksum cannot be computed");
  }
  const Grid grid(study.campaign);
  return Journal::Open(
      absl::StrCat(folder, "/journal.csv"),
      {.checksum = checksum,
       .version = std::string(Version()),
       .runs = grid.num_runs()},
      [&](std::int64_t run) {
        return experiment::RowStart(study.campaign, grid, run);
      },
      resume);
}

// Puts the runs of all parts that the folder has into its journal.
absl::Status TakeParts(const Study& study, StudyFolder& folder) {
  std::error_code none;
  std::set<std::string> parts;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder.path + "/parts", none)) {
    parts.insert(entry.path().string());
  }
  for (const std::string& path : parts) {
    const absl::StatusOr<FolderLock> lock = FolderLock::Take(path);
    if (!lock.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--out: ", lock.status().message()));
    }
    MLE_ASSIGN_OR_RETURN(const std::unique_ptr<Journal> part,
                         OpenJournal(study, path, /*resume=*/true));
    for (std::int64_t run = 0; run < folder.runs; ++run) {
      if (!part->IsDone(run) || folder.journal->IsDone(run)) continue;
      MLE_ASSIGN_OR_RETURN(const std::string line, part->Line(run));
      MLE_RETURN_IF_ERROR(folder.journal->Append(run, line));
    }
  }
  return folder.journal->Sync();
}

// Threads that take one unit of work after the other.
class Crew {
 public:
  Crew(const Campaign& campaign, StudyFolder& folder)
      : campaign_(campaign), grid_(campaign), folder_(folder) {}

  absl::Status Run(int threads, const std::function<bool()>& stopped,
                   const ProgressFunction& told) {
    told(folder_.num_done(), folder_.runs);
    working_ = threads;
    std::vector<std::thread> workers;
    for (int i = 0; i < threads; ++i) workers.emplace_back([this] { Work(); });
    std::unique_lock<std::mutex> lock(mutex_);
    std::int64_t shown = folder_.num_done();
    while (working_ > 0) {
      changed_.wait_for(lock, kPause, [&] {
        return working_ == 0 || folder_.num_done() > shown;
      });
      shown = folder_.num_done();
      lock.unlock();
      told(shown, folder_.runs);
      if (stopped()) stop_ = true;
      lock.lock();
    }
    lock.unlock();
    for (std::thread& worker : workers) worker.join();
    status_.Update(folder_.journal->Sync());
    return status_;
  }

 private:
  // The runs of the next unit that are left; empty if there are none.
  std::vector<std::int64_t> Next() {
    std::vector<std::int64_t> runs;
    for (; runs.empty() && next_unit_ < grid_.num_units(); ++next_unit_) {
      if (!folder_.part.Has(next_unit_)) continue;
      for (const std::int64_t run : grid_.RunsOf(next_unit_)) {
        if (!folder_.journal->IsDone(run)) runs.push_back(run);
      }
    }
    return runs;
  }

  void Work() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!stop_) {
      const std::vector<std::int64_t> runs = Next();
      if (runs.empty()) break;
      lock.unlock();
      RunUnit(campaign_, grid_, runs, stop_,
              [this](const experiment::Outcome& outcome) {
                const std::string line =
                    RowText(campaign_, grid_, experiment::RowOf(outcome));
                const std::lock_guard<std::mutex> held(mutex_);
                status_.Update(folder_.journal->Append(outcome.run, line));
                if (!status_.ok()) stop_ = true;
                changed_.notify_all();
              });
      lock.lock();
    }
    --working_;
    changed_.notify_all();
  }

  const Campaign& campaign_;
  const Grid grid_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  StudyFolder& folder_;
  std::int64_t next_unit_ = 0;
  int working_ = 0;
  absl::Status status_;
};

}  // namespace

absl::StatusOr<Study> ReadStudy(std::string_view text,
                                const std::string& source,
                                const std::string& folder) {
  Study study;
  MLE_ASSIGN_OR_RETURN(study.resolved, ResolveCampaign(text, source, folder));
  MLE_ASSIGN_OR_RETURN(study.campaign, ParseCampaign(study.resolved, source));
  return study;
}

absl::StatusOr<StudyFolder> OpenFolder(const Study& study,
                                       const std::string& path,
                                       const Part& part, bool resume) {
  const std::string own = part.FolderBelow(path);
  MLE_ASSIGN_OR_RETURN(FolderLock lock, ClaimOutputFolder(own));
  MLE_ASSIGN_OR_RETURN(std::unique_ptr<Journal> journal,
                       OpenJournal(study, own, resume));
  StudyFolder folder{own, part, std::move(lock), std::move(journal)};
  const Grid grid(study.campaign);
  for (std::int64_t unit = 0; unit < grid.num_units(); ++unit) {
    if (!part.Has(unit)) continue;
    folder.runs += static_cast<std::int64_t>(grid.RunsOf(unit).size());
  }
  if (part.is_everything()) MLE_RETURN_IF_ERROR(TakeParts(study, folder));
  MLE_RETURN_IF_ERROR(
      WriteFileAtomically(absl::StrCat(own, "/campaign.json"), study.resolved));
  return folder;
}

int StudyThreads(int wanted) {
  if (wanted > 0) return UsableThreads(wanted);
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof(set), &set) == 0
             ? std::max(CPU_COUNT(&set), 1)
             : std::max(static_cast<int>(std::thread::hardware_concurrency()),
                        1);
}

absl::Status RunRemaining(const Study& study, StudyFolder& folder, int threads,
                          const std::function<bool()>& stopped,
                          const ProgressFunction& told) {
  return Crew(study.campaign, folder).Run(threads, stopped, told);
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
