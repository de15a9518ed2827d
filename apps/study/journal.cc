#include "apps/study/journal.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/experiment/row.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

using experiment::ParseRow;
using experiment::Row;
using experiment::RowHeader;

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kBatch = 64;

absl::Status FileError(const std::string& path, const char* what) {
  return absl::InternalError(
      absl::StrCat(path, ": ", what, ": ", std::strerror(errno)));
}

absl::Status BadLine(const std::string& path, std::int64_t number,
                     std::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(path, ":", number, ": ", std::string(what)));
}

}  // namespace

std::string JournalHead::Line() const {
  return absl::StrFormat(
      "# mle_study journal 1, campaign SHA-256 %s, mle %s, "
      "%d runs",
      checksum, version, runs);
}

Journal::Journal(std::string path, int file, std::int64_t runs)
    : path_(std::move(path)),
      file_(file),
      offsets_(static_cast<std::size_t>(runs), -1),
      last_sync_(Clock::now()) {}

Journal::~Journal() {
  if (unsynced_ > 0) fsync(file_);
  close(file_);
}

absl::StatusOr<std::unique_ptr<Journal>> Journal::Open(const std::string& path,
                                                       const JournalHead& head,
                                                       bool resume) {
  struct stat there = {};
  const bool exists = stat(path.c_str(), &there) == 0 && there.st_size > 0;
  if (exists && !resume) {
    return absl::InvalidArgumentError(
        absl::StrCat(path,
                     ": there is a campaign in this folder already: resume it "
                     "with --resume, or use another folder"));
  }
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) return FileError(path, "cannot be opened");
  std::unique_ptr<Journal> journal(new Journal(path, file, head.runs));
  if (exists) {
    MLE_RETURN_IF_ERROR(journal->ReadBack(head));
  }
  if (journal->size_ == 0) {
    MLE_RETURN_IF_ERROR(journal->WriteHead(head));
  }
  return journal;
}

absl::Status Journal::WriteHead(const JournalHead& head) {
  MLE_RETURN_IF_ERROR(
      Write(absl::StrCat(head.Line(), "\n", RowHeader(true), "\n")));
  return Sync();
}

// Reads what is there line by line. A file that breaks off, or ends in bytes
// that are no line, as after a power cut, ends where the last whole line does.
absl::Status Journal::ReadBack(const JournalHead& head) {
  std::ifstream input(path_, std::ios::binary);
  if (!input) return FileError(path_, "cannot be read");
  std::string line;
  std::int64_t number = 0;
  int head_lines = 0;
  std::int64_t offset = 0;
  absl::Status bad;
  std::int64_t end = 0;
  while (std::getline(input, line)) {
    const bool whole = !input.eof();
    const std::int64_t begin = offset;
    offset += static_cast<std::int64_t>(line.size()) + (whole ? 1 : 0);
    ++number;
    if (!whole) break;
    if (!bad.ok()) return bad;  // Not the last line: the file is damaged.
    if (number <= 2) {
      const std::string wanted = number == 1 ? head.Line() : RowHeader(true);
      if (line != wanted) {
        return BadLine(path_, number,
                       absl::StrCat("belongs to another campaign, version or "
                                    "file: '",
                                    line.substr(0, 200), "', where '", wanted,
                                    "' is needed; take another folder"));
      }
      end = offset;
      ++head_lines;
      continue;
    }
    const absl::StatusOr<Row> row = ParseRow(line, /*with_seconds=*/true);
    if (!row.ok()) {
      bad = BadLine(path_, number, std::string(row.status().message()));
      continue;
    }
    if (row->run >= head.runs || IsDone(row->run)) {
      return BadLine(
          path_, number,
          absl::StrCat("run ", row->run,
                       row->run >= head.runs ? " is beyond the campaign's last"
                                             : " stands twice"));
    }
    offsets_[row->run] = begin;
    ++num_done_;
    end = offset;
  }
  dropped_bytes_ = offset - end;
  // The two lines of the head are not whole: begin anew.
  if (head_lines < 2) {
    dropped_bytes_ = offset;
    end = 0;
  }
  if (ftruncate(file_, end) != 0) return FileError(path_, "cannot be cut");
  size_ = end;
  return absl::OkStatus();
}

absl::Status Journal::Write(std::string_view text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count =
        pwrite(file_, text.data() + written, text.size() - written,
               static_cast<off_t>(size_ + static_cast<std::int64_t>(written)));
    if (count < 0) {
      if (errno == EINTR) continue;
      return FileError(path_, "cannot be written");
    }
    written += static_cast<std::size_t>(count);
  }
  size_ += static_cast<std::int64_t>(text.size());
  return absl::OkStatus();
}

absl::Status Journal::Append(std::int64_t run, std::string_view line) {
  if (run < 0 || run >= static_cast<std::int64_t>(offsets_.size()) ||
      IsDone(run)) {
    return absl::InternalError(
        absl::StrCat(path_, ": run ", run, " ended twice, or is none"));
  }
  const std::int64_t begin = size_;
  MLE_RETURN_IF_ERROR(Write(absl::StrCat(std::string(line), "\n")));
  offsets_[run] = begin;
  ++num_done_;
  ++unsynced_;
  if (unsynced_ >= kBatch ||
      Clock::now() - last_sync_ > std::chrono::seconds(1)) {
    return Sync();
  }
  return absl::OkStatus();
}

absl::Status Journal::Sync() {
  if (fsync(file_) != 0) return FileError(path_, "cannot be flushed");
  unsynced_ = 0;
  last_sync_ = Clock::now();
  return absl::OkStatus();
}

absl::StatusOr<std::string> Journal::Line(std::int64_t run) const {
  std::string line;
  std::array<char, 512> block;
  std::int64_t offset = offsets_[run];
  while (true) {
    const ssize_t count = pread(file_, block.data(), block.size(), offset);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return FileError(path_, "cannot be read back");
    const std::string_view text(block.data(), static_cast<std::size_t>(count));
    const std::size_t end = text.find('\n');
    line += text.substr(0, end);
    if (end != std::string_view::npos) return line;
    offset += count;
  }
}

}  // namespace mle::study
