// The runs of a campaign, whatever they are, in a folder that one command at a
// time has for itself: a journal (journal.h), from which an interrupted
// campaign resumes, and threads that do what is left. Parts of a campaign
// (apps/common/part.h) have folders of their own below it, and may run at once,
// on any machines that see the folder.
//
//   MLE_ASSIGN_OR_RETURN(RunFolder folder,
//                        RunFolder::Open(work, "study", Part(), resume));
//   MLE_RETURN_IF_ERROR(folder.RunRemaining(work, threads, stopped, told));
//   if (folder.is_done()) … folder.journal().Line(run) …

#ifndef APPS_EXPERIMENT_RUN_FOLDER_H_
#define APPS_EXPERIMENT_RUN_FOLDER_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/part.h"
#include "apps/common/progress.h"
#include "apps/experiment/journal.h"
#include "mle/base/folder_lock.h"

namespace mle::experiment {

// The work of a campaign: its journal, its units and their runs.
struct Work {
  std::string file;  // of the journal, in the folder
  JournalHead head;
  // Units of work, which are dealt to threads and parts, in their order.
  std::int64_t units = 0;
  std::function<std::vector<std::int64_t>(std::int64_t unit)> runs_of;
  // Some runs of one unit; each gives its line of the journal. No further run
  // is begun once `stop` is set. What it depends on outlives the work.
  using Emit = std::function<void(std::int64_t run, const std::string& line)>;
  std::function<absl::Status(const std::vector<std::int64_t>& runs,
                             const std::atomic<bool>& stop, const Emit& emit)>
      run;
};

class RunFolder {
 public:
  // Locks the folder of the part and opens its journal. For everything, the
  // runs that parts have done are taken over; InvalidArgument where a part is
  // at work or is of another campaign.
  static absl::StatusOr<RunFolder> Open(const Work& work,
                                        const std::string& path,
                                        const Part& part, bool resume);

  // Until every run of the part is in the journal, or `stopped` says so (then
  // the runs under way are still waited for) or a run fails. `told` is called
  // with the runs done and all of them, in the beginning and several times a
  // second. Both are called by the caller's thread.
  absl::Status RunRemaining(const Work& work, int threads,
                            const std::function<bool()>& stopped,
                            const ProgressFunction& told);

  // The same as a command does it, until a signal stops it: says what was found
  // in the journal, how far it is, and, where there is nothing to conclude yet,
  // how to go on. Whether every run is there. `what`: "runs"; `resume`: the
  // flag that resumes, if one is needed.
  absl::StatusOr<bool> RunAsCommand(const Work& work, const std::string& what,
                                    const std::string& resume, int threads);

  const std::string& path() const { return path_; }
  const Part& part() const { return part_; }
  Journal& journal() const { return *journal_; }
  std::int64_t runs() const { return runs_; }  // of the part
  std::int64_t num_done() const { return journal_->num_done(); }
  bool is_done() const { return num_done() == runs_; }

 private:
  RunFolder(std::string path, Part part, FolderLock lock,
            std::unique_ptr<Journal> journal)
      : path_(std::move(path)),
        part_(std::move(part)),
        lock_(std::move(lock)),
        journal_(std::move(journal)) {}
  absl::Status TakeParts(const Work& work);
  void PrintFound(const std::string& what) const;

  std::string path_;
  Part part_;
  FolderLock lock_;
  std::unique_ptr<Journal> journal_;
  std::int64_t runs_ = 0;
};

// `wanted`, as far as there are processors, or, where that is 0, those that
// this process may use.
int RunThreads(int wanted);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_RUN_FOLDER_H_
