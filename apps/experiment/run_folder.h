// The runs of a campaign, whatever they are, in a folder that one command at a
// time has for itself: a journal, from which an interrupted campaign resumes,
// and threads that do what is left. Parts of a campaign (apps/common/part.h)
// have folders of their own below it, and may run at once, on any machines that
// see the folder.
//
//   MLE_ASSIGN_OR_RETURN(RunFolder folder,
//                        RunFolder::Open(work, "study", Part(), resume));
//   MLE_RETURN_IF_ERROR(folder.RunRemaining(work, threads, stopped, told));
//   if (folder.is_done()) … folder.journal().Line(run) …

#ifndef APPS_EXPERIMENT_RUN_FOLDER_H_
#define APPS_EXPERIMENT_RUN_FOLDER_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/part.h"
#include "apps/common/progress.h"
#include "mle/base/folder_lock.h"

namespace mle::experiment {

// The journal of a campaign: a file with a line for each run, in the order in
// which they ended.
//
//   # mle_study journal 2, campaign SHA-256 …, mle 0.1.0, 1000 runs
//   run,model,…,status,seconds,checksum
//   17,wood_berry,…,ok,0.31,5f2c9a01e7d3b864
//
// The checksum is the first 16 digits of the SHA-256 of what stands before it.
// Lines are written whole and forced to the disk in batches. What a crash left
// of the last line is recognised and dropped when the journal is opened again,
// and a line whose checksum is wrong, or that is of no run, is left out, so
// that its run counts as not done; a journal with another head is refused. Only
// the numbers of the runs done are kept in memory: a byte offset each. Who has
// a journal open holds the folder's lock (folder_lock.h).

// The campaign of a journal: its first lines and its runs.
struct JournalHead {
  std::string first_line;  // names the campaign
  std::string columns;     // but for the checksum; empty: there is no such line
  std::int64_t runs = 0;
  // The number of the run that a line is of, or why it is of none.
  std::function<absl::StatusOr<std::int64_t>(std::string_view line)> run_of;
  // The run is not asked for: its line stays, and is not read.
  static constexpr std::int64_t kNotAskedFor = -1;
};

class Journal {
 public:
  // Opens or makes `path`. With `resume` false a journal that is there already
  // is an error, and the message says how to go on. Otherwise its runs count
  // as done. InvalidArgument names file and line of what is wrong.
  static absl::StatusOr<std::unique_ptr<Journal>> Open(const std::string& path,
                                                       const JournalHead& head,
                                                       bool resume);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  const std::string& path() const { return path_; }
  std::int64_t num_done() const { return num_done_; }
  bool IsDone(std::int64_t run) const { return offsets_[run] >= 0; }

  // A line for a run that is not done, without its line end. On the disk after
  // Sync(), or within a second or so of further calls.
  absl::Status Append(std::int64_t run, std::string_view line);
  absl::Status Sync();

  // The line of a run that is done. Internal if it has changed since.
  absl::StatusOr<std::string> Line(std::int64_t run) const;

  // Bytes of a last line that was not whole, dropped on opening.
  std::int64_t dropped_bytes() const { return dropped_bytes_; }
  // Numbers of the lines that were found damaged on opening.
  const std::vector<std::int64_t>& damaged_lines() const {
    return damaged_lines_;
  }

 private:
  Journal(std::string path, int file, std::int64_t runs);
  absl::Status WriteHead(const JournalHead& head);
  absl::Status ReadBack(const JournalHead& head);
  absl::Status TakeLine(const JournalHead& head, std::string_view line,
                        std::int64_t number, std::int64_t begin);
  absl::Status Write(std::string_view text);

  const std::string path_;
  const int file_;
  std::vector<std::int64_t> offsets_;  // of each run's line; −1: not done
  std::int64_t num_done_ = 0;
  std::int64_t size_ = 0;
  std::int64_t dropped_bytes_ = 0;
  std::vector<std::int64_t> damaged_lines_;
  std::int64_t unsynced_ = 0;
  std::chrono::steady_clock::time_point last_sync_;
};

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
