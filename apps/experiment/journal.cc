#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/sha256.h"
#include "apps/experiment/run_folder.h"
#include "mle/base/status.h"

namespace mle::experiment {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kBatch = 64;

absl::Status FileError(const std::string& path, const char* what) {
  return absl::InternalError(
      absl::StrCat(path, ": ", what, ": ", std::strerror(errno)));
}

absl::Status BadLine(const std::string& path, std::int64_t number,
                     std::string_view what) {
  return InvalidArgument(path, ":", number, ": ", std::string(what));
}

std::string ColumnsOf(const JournalHead& head) {
  return head.columns.empty() ? "" : absl::StrCat(head.columns, ",checksum");
}

std::string ChecksumOf(std::string_view text) {
  return Sha256Of(text).substr(0, 16);
}

// The line up to its checksum; nothing if that is another's.
std::optional<std::string_view> WithoutChecksum(std::string_view line) {
  const std::size_t comma = line.rfind(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::string_view text = line.substr(0, comma);
  if (line.substr(comma + 1) != ChecksumOf(text)) return std::nullopt;
  return text;
}

}  // namespace

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
    return InvalidArgument(path,
                           ": there is a campaign in this folder already: "
                           "resume it with --resume, or use another folder");
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
  MLE_RETURN_IF_ERROR(Write(absl::StrCat(head.first_line, "\n", ColumnsOf(head),
                                         head.columns.empty() ? "" : "\n")));
  return Sync();
}

// Counts the run of a line as done, if the line is what was written.
absl::Status Journal::TakeLine(const JournalHead& head, std::string_view line,
                               std::int64_t number, std::int64_t begin) {
  const std::optional<std::string_view> text = WithoutChecksum(line);
  const absl::StatusOr<std::int64_t> run =
      text.has_value() ? head.run_of(*text) : absl::DataLossError("checksum");
  if (run.ok() && *run == JournalHead::kNotAskedFor) return absl::OkStatus();
  if (!run.ok() || *run < 0 || *run >= head.runs) {
    damaged_lines_.push_back(number);
    return absl::OkStatus();
  }
  if (IsDone(*run)) {
    return BadLine(path_, number,
                   absl::StrCat("run ", *run,
                                " is duplicated; remove the line that is "
                                "wrong, or both for it to be run again"));
  }
  offsets_[*run] = begin;
  ++num_done_;
  return absl::OkStatus();
}

// Reads what is there line by line. A file that breaks off ends where its last
// whole line does.
absl::Status Journal::ReadBack(const JournalHead& head) {
  std::ifstream input(path_, std::ios::binary);
  if (!input) return FileError(path_, "cannot be read");
  const std::string columns = ColumnsOf(head);
  const int head_lines = head.columns.empty() ? 1 : 2;
  std::string line;
  std::int64_t number = 0;
  std::int64_t end = 0;  // of the last whole line
  std::int64_t size = 0;
  while (std::getline(input, line)) {
    size += static_cast<std::int64_t>(line.size());
    if (input.eof()) break;
    ++size;
    ++number;
    if (number <= head_lines) {
      const std::string& wanted = number == 1 ? head.first_line : columns;
      if (line != wanted) {
        return BadLine(path_, number,
                       absl::StrCat("belongs to another campaign, version or "
                                    "file: '",
                                    line.substr(0, 200), "', where '", wanted,
                                    "' is needed; take another folder"));
      }
    } else {
      MLE_RETURN_IF_ERROR(TakeLine(head, line, number, end));
    }
    end = size;
  }
  // The lines of the head are not whole: begin anew.
  if (number < head_lines) end = 0;
  dropped_bytes_ = size - end;
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
  MLE_RETURN_IF_ERROR(
      Write(absl::StrCat(std::string(line), ",", ChecksumOf(line), "\n")));
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
    if (end != std::string_view::npos) break;
    offset += count;
  }
  const std::optional<std::string_view> text = WithoutChecksum(line);
  if (!text.has_value()) {
    return absl::InternalError(
        absl::StrCat(path_, ": the line of run ", run,
                     " has changed since it was written; give the same command "
                     "with --resume to do this run again"));
  }
  return std::string(*text);
}

}  // namespace mle::experiment
