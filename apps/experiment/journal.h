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

#ifndef APPS_EXPERIMENT_JOURNAL_H_
#define APPS_EXPERIMENT_JOURNAL_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle::experiment {

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

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_JOURNAL_H_
