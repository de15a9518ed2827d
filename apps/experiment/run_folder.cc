#include "apps/experiment/run_folder.h"

#include <sched.h>

#include <algorithm>
#include <condition_variable>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <set>
#include <thread>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/process_faults.h"
#include "mle/base/status.h"

namespace mle::experiment {
namespace {

// Between two looks at signals.
constexpr std::chrono::milliseconds kPause(100);

// Threads that take one unit of work after the other.
class Crew {
 public:
  Crew(const Work& work, const RunFolder& folder)
      : work_(work), folder_(folder), journal_(folder.journal()) {}

  absl::Status Run(int threads, const std::function<bool()>& stopped,
                   const ProgressFunction& told) {
    std::int64_t shown = folder_.num_done();
    told(shown, folder_.runs());
    working_ = threads;
    std::vector<std::thread> workers;
    for (int i = 0; i < threads; ++i) workers.emplace_back([this] { Deal(); });
    std::unique_lock<std::mutex> lock(mutex_);
    while (working_ > 0) {
      changed_.wait_for(lock, kPause, [&] {
        return working_ == 0 || folder_.num_done() > shown;
      });
      shown = folder_.num_done();
      lock.unlock();
      told(shown, folder_.runs());
      if (stopped()) stop_ = true;
      lock.lock();
    }
    lock.unlock();
    for (std::thread& worker : workers) worker.join();
    status_.Update(journal_.Sync());
    return status_;
  }

 private:
  // The runs of the next unit that are left; empty if there are none.
  std::vector<std::int64_t> Next() {
    std::vector<std::int64_t> runs;
    for (; runs.empty() && next_unit_ < work_.units; ++next_unit_) {
      if (!folder_.part().Has(next_unit_)) continue;
      for (const std::int64_t run : work_.runs_of(next_unit_)) {
        if (!journal_.IsDone(run)) runs.push_back(run);
      }
    }
    return runs;
  }

  void Deal() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!stop_) {
      const std::vector<std::int64_t> runs = Next();
      if (runs.empty()) break;
      lock.unlock();
      const absl::Status status = work_.run(
          runs, stop_, [this](std::int64_t run, const std::string& line) {
            const std::lock_guard<std::mutex> held(mutex_);
            Note(journal_.Append(run, line));
          });
      lock.lock();
      Note(status);
    }
    --working_;
    changed_.notify_all();
  }

  void Note(const absl::Status& status) {
    status_.Update(status);
    if (!status.ok()) stop_ = true;
    changed_.notify_all();
  }

  const Work& work_;
  const RunFolder& folder_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  Journal& journal_;
  std::int64_t next_unit_ = 0;
  int working_ = 0;
  absl::Status status_;
};

}  // namespace

absl::StatusOr<RunFolder> RunFolder::Open(const Work& work,
                                          const std::string& path,
                                          const Part& part, bool resume) {
  const std::string own = part.FolderBelow(path);
  MLE_ASSIGN_OR_RETURN(FolderLock lock, ClaimOutputFolder(own));
  MLE_ASSIGN_OR_RETURN(
      std::unique_ptr<Journal> journal,
      Journal::Open(absl::StrCat(own, "/", work.file), work.head, resume));
  RunFolder folder(own, part, std::move(lock), std::move(journal));
  for (std::int64_t unit = 0; unit < work.units; ++unit) {
    if (!part.Has(unit)) continue;
    folder.runs_ += static_cast<std::int64_t>(work.runs_of(unit).size());
  }
  if (part.is_everything()) MLE_RETURN_IF_ERROR(folder.TakeParts(work));
  return folder;
}

absl::Status RunFolder::TakeParts(const Work& work) {
  std::error_code none;
  std::set<std::string> parts;
  for (const auto& entry :
       std::filesystem::directory_iterator(path_ + "/parts", none)) {
    parts.insert(entry.path().string());
  }
  for (const std::string& path : parts) {
    MLE_ASSIGN_OR_RETURN(const FolderLock lock,
                         AboutOption("out", FolderLock::Take(path)));
    MLE_ASSIGN_OR_RETURN(const std::unique_ptr<Journal> part,
                         Journal::Open(absl::StrCat(path, "/", work.file),
                                       work.head, /*resume=*/true));
    for (std::int64_t run = 0; run < work.head.runs; ++run) {
      if (!part->IsDone(run) || journal_->IsDone(run)) continue;
      MLE_ASSIGN_OR_RETURN(const std::string line, part->Line(run));
      MLE_RETURN_IF_ERROR(journal_->Append(run, line));
    }
  }
  return journal_->Sync();
}

absl::Status RunFolder::RunRemaining(const Work& work, int threads,
                                     const std::function<bool()>& stopped,
                                     const ProgressFunction& told) {
  return Crew(work, *this).Run(threads, stopped, told);
}

void RunFolder::PrintFound(const std::string& what) const {
  constexpr std::size_t kShown = 5;
  const std::string& file = journal_->path();
  if (journal_->dropped_bytes() > 0) {
    std::cerr << file << ": an incomplete last line is dropped ("
              << journal_->dropped_bytes() << " bytes)\n";
  }
  const std::vector<std::int64_t>& damaged = journal_->damaged_lines();
  for (std::size_t i = 0; i < std::min(damaged.size(), kShown); ++i) {
    std::cerr << "warning: " << file << ":" << damaged[i]
              << ": the line is damaged (its checksum or its coordinates are "
                 "wrong); its run is done again\n";
  }
  if (damaged.size() > kShown) {
    std::cerr << "warning: " << file << ": " << damaged.size() - kShown
              << " more lines are damaged\n";
  }
  if (num_done() > 0) {
    std::cerr << "Going on: " << num_done() << " of " << runs_ << " " << what
              << " are done.\n";
  }
}

absl::StatusOr<bool> RunFolder::RunAsCommand(const Work& work,
                                             const std::string& what,
                                             const std::string& resume,
                                             int threads) {
  PrintFound(what);
  CatchStopSignals();
  MLE_RETURN_IF_ERROR(RunRemaining(work, RunThreads(threads), StopRequested,
                                   ShowProgress(what)));
  if (!is_done()) {
    std::cerr << "Stopped: " << num_done() << " of " << runs_ << " " << what
              << " are done, in " << journal_->path()
              << ". Give the same command " << resume << "to resume.\n";
    return false;
  }
  if (!part_.is_everything()) {
    std::cout << "Part " << part_.text << ": all of its " << runs_ << " "
              << what
              << " are done. When the other parts are, give the same command "
                 "without --part.\n";
    return false;
  }
  return true;
}

int RunThreads(int wanted) {
  if (wanted > 0) return UsableThreads(wanted);
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof(set), &set) == 0
             ? std::max(CPU_COUNT(&set), 1)
             : std::max(static_cast<int>(std::thread::hardware_concurrency()),
                        1);
}

}  // namespace mle::experiment
