// The journal of a campaign: DIR/journal.csv, one line a run, in the order in
// which they ended.
//
//   # mle_study journal 2, campaign SHA-256 …, mle 0.1.0, 1000 runs
//   run,model,…,status,seconds,checksum
//   17,wood_berry,…,ok,0.31,5f2c9a01e7d3b864
//
// The checksum is the first 16 digits of the SHA-256 of what stands before it.
// Lines are written whole and forced to the disk in batches. What a crash left
// of the last line is recognised and dropped when the journal is opened again,
// and a line whose checksum or coordinates are wrong is left out, so that its
// run counts as not done; a journal of another campaign or version is refused.
// Only the numbers of the runs done are kept in memory: a byte offset each.
// Who has a journal open holds the folder's lock (folder_lock.h).

#ifndef APPS_STUDY_JOURNAL_H_
#define APPS_STUDY_JOURNAL_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle::study {

struct JournalHead {
  std::string checksum;  // SHA-256 of the resolved campaign
  std::string version;   // of the program
  std::int64_t runs = 0;

  std::string Line() const;
};

class Journal {
 public:
  // What a run's line begins with (RowStart() of row.h).
  using LineStart = std::function<std::string(std::int64_t run)>;

  // Opens or makes `path`. With `resume` false a journal that is there already
  // is an error, and the message says how to go on. Otherwise its runs count
  // as done. InvalidArgument names file and line of what is wrong.
  static absl::StatusOr<std::unique_ptr<Journal>> Open(
      const std::string& path, const JournalHead& head,
      const LineStart& line_start, bool resume);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  std::int64_t num_done() const { return num_done_; }
  bool IsDone(std::int64_t run) const { return offsets_[run] >= 0; }

  // A line of row.h for a run that is not done, without its line end. On the
  // disk after Sync(), or within a second or so of further calls.
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
  absl::Status ReadBack(const JournalHead& head, const LineStart& line_start);
  absl::Status TakeLine(std::string_view line, std::int64_t number,
                        std::int64_t begin, const LineStart& line_start);
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

// The journal, sorted: runs.csv, whose bytes depend on the campaign alone, and
// timings.csv.

// All runs must be in the journal. Files are written line by line beside their
// place and renamed, whole or not at all.
absl::Status MergeRuns(const Journal& journal, std::int64_t runs,
                       const std::string& folder);

}  // namespace mle::study

#endif  // APPS_STUDY_JOURNAL_H_
