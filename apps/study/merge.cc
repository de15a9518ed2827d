#include "apps/study/merge.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/experiment/row.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

using experiment::RowHeader;
using experiment::WithoutSeconds;

// A file that takes its name once it is whole and on the disk.
class NewFile {
 public:
  explicit NewFile(std::string path)
      : path_(std::move(path)),
        part_(absl::StrCat(path_, ".part")),
        file_(std::fopen(part_.c_str(), "wb")),
        good_(file_ != nullptr) {}

  ~NewFile() {
    if (file_ != nullptr) std::fclose(file_);
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  void Add(const std::string& line) {
    good_ = good_ && std::fputs(line.c_str(), file_) >= 0 &&
            std::fputc('\n', file_) != EOF;
  }

  absl::Status Finish() {
    good_ = good_ && std::fflush(file_) == 0 && fsync(fileno(file_)) == 0 &&
            std::rename(part_.c_str(), path_.c_str()) == 0;
    if (good_) return absl::OkStatus();
    return absl::InternalError(
        absl::StrCat(path_, ": cannot be written: ", std::strerror(errno)));
  }

 private:
  const std::string path_;
  const std::string part_;
  std::FILE* const file_;
  bool good_;
};

}  // namespace

absl::Status MergeRuns(const Journal& journal, std::int64_t runs,
                       const std::string& folder) {
  NewFile merged(absl::StrCat(folder, "/runs.csv"));
  NewFile timings(absl::StrCat(folder, "/timings.csv"));
  merged.Add(RowHeader(/*with_seconds=*/false));
  timings.Add("run,seconds");
  for (std::int64_t run = 0; run < runs; ++run) {
    MLE_ASSIGN_OR_RETURN(const std::string line, journal.Line(run));
    merged.Add(WithoutSeconds(line));
    timings.Add(absl::StrCat(run, ",", line.substr(line.rfind(',') + 1)));
  }
  MLE_RETURN_IF_ERROR(merged.Finish());
  return timings.Finish();
}

}  // namespace mle::study
