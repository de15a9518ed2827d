#include "mle/base/file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <new>
#include <stdexcept>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// Closes a descriptor when it goes out of scope.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }

  int get() const { return fd_; }
  // Closes now, so that a failure can be seen.
  int Close() {
    const int result = ::close(fd_);
    fd_ = -1;
    return result;
  }

 private:
  int fd_;
};

absl::Status ErrnoStatus(const char* action, const std::string& path) {
  const int error = errno;
  return absl::ErrnoToStatus(error, absl::StrCat(action, " '", path, "'"));
}

// A name beside `path` that no other writer uses.
std::string TemporaryName(const std::string& path) {
  static std::atomic<unsigned> counter = 0;
  const std::filesystem::path target(path);
  const std::string name = absl::StrCat(".", target.filename().string(), ".",
                                        ::getpid(), ".", counter++, ".tmp");
  return (target.parent_path() / name).string();
}

// Whether TemporaryName() makes such names: ".result.json.1234.7.tmp".
bool IsTemporary(const std::string& name) {
  const std::vector<std::string> parts = absl::StrSplit(name, '.');
  const auto is_number = [](const std::string& part) {
    return !part.empty() &&
           std::all_of(part.begin(), part.end(), absl::ascii_isdigit);
  };
  const std::size_t n = parts.size();
  return n >= 5 && parts.front().empty() && is_number(parts[n - 3]) &&
         is_number(parts[n - 2]) && parts.back() == "tmp";
}

absl::Status WriteAll(int fd, std::string_view content,
                      const std::string& path) {
  while (!content.empty()) {
    const ssize_t written = ::write(fd, content.data(), content.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return ErrnoStatus("cannot write", path);
    }
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return absl::OkStatus();
}

// The folder that a path lies in.
std::string FolderOf(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

// A file that is on the disk but does not have its name yet. Where the file
// system can (O_TMPFILE), it has no name at all, so that nothing is left of it
// if the program is killed.
class StagedFile {
 public:
  explicit StagedFile(const std::string& path)
      : path_(path), temporary_(TemporaryName(path)) {}
  StagedFile(StagedFile&& other) noexcept
      : path_(std::move(other.path_)),
        temporary_(std::exchange(other.temporary_, "")),
        unnamed_(std::move(other.unnamed_)),
        old_(std::exchange(other.old_, "")),
        existed_(other.existed_),
        changed_(other.changed_) {}
  StagedFile& operator=(StagedFile&&) = delete;
  ~StagedFile() {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
    if (!old_.empty()) ::unlink(old_.c_str());
  }

  absl::Status Write(std::string_view content) {
    if (::access("/proc/self/fd", X_OK) == 0) {
      unnamed_ = std::make_unique<Descriptor>(::open(
          FolderOf(path_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666));
    }
    if (unnamed_ != nullptr && unnamed_->get() >= 0) {
      return WriteAndSync(unnamed_->get(), content);
    }
    unnamed_.reset();
    Descriptor file(::open(temporary_.c_str(),
                           O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.get() < 0) return ErrnoStatus("cannot create", temporary_);
    MLE_RETURN_IF_ERROR(WriteAndSync(file.get(), content));
    if (file.Close() != 0) return ErrnoStatus("cannot close", temporary_);
    return absl::OkStatus();
  }

  // Keeps what has the name now under another, for TakeBack(). Where it
  // cannot (no hard links), what is replaced is lost.
  void KeepOld() {
    existed_ = ::access(path_.c_str(), F_OK) == 0;
    const std::string old = TemporaryName(path_);
    if (existed_ && ::link(path_.c_str(), old.c_str()) == 0) old_ = old;
  }

  // Undoes Commit() or Remove().
  void TakeBack() {
    if (!changed_) return;
    if (!old_.empty()) {
      if (std::rename(old_.c_str(), path_.c_str()) == 0) old_.clear();
    } else if (!existed_) {
      ::unlink(path_.c_str());
    }
  }

  absl::Status Remove() {
    if (::unlink(path_.c_str()) != 0 && errno != ENOENT) {
      return ErrnoStatus("cannot remove", path_);
    }
    changed_ = true;
    return absl::OkStatus();
  }

  // Takes the place of what has the name now.
  absl::Status Commit() {
    if (unnamed_ != nullptr) {
      const std::string link = absl::StrCat("/proc/self/fd/", unnamed_->get());
      if (::linkat(AT_FDCWD, link.c_str(), AT_FDCWD, temporary_.c_str(),
                   AT_SYMLINK_FOLLOW) != 0) {
        return ErrnoStatus("cannot create", temporary_);
      }
    }
    if (std::rename(temporary_.c_str(), path_.c_str()) != 0) {
      return ErrnoStatus("cannot replace", path_);
    }
    temporary_.clear();
    changed_ = true;
    return absl::OkStatus();
  }

  const std::string& path() const { return path_; }

 private:
  absl::Status WriteAndSync(int fd, std::string_view content) {
    MLE_RETURN_IF_ERROR(WriteAll(fd, content, path_));
    if (::fsync(fd) != 0) return ErrnoStatus("cannot sync", path_);
    return absl::OkStatus();
  }

  std::string path_;
  std::string temporary_;
  std::unique_ptr<Descriptor> unnamed_;
  std::string old_;       // another name of what is replaced
  bool existed_ = false;  // before it was replaced
  bool changed_ = false;
};

// Renaming would replace a device or a pipe by a file.
absl::Status CheckReplaceable(const std::string& path) {
  if (path.empty()) {
    return absl::InvalidArgumentError("cannot write a file without a name");
  }
  struct stat info = {};
  if (::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot write '", path,
                     S_ISDIR(info.st_mode) ? "': it is a folder"
                                           : "': it is not a regular file"));
  }
  return absl::OkStatus();
}

absl::Status CannotWrite(const std::string& path, const absl::Status& reason) {
  return absl::Status(reason.code(), absl::StrCat("cannot write '", path,
                                                  "': ", reason.message()));
}

// New names last through a loss of power once their folder is on the disk too.
// Not every file system can; the files themselves are safe without.
void SyncFolder(const std::string& folder) {
  const Descriptor opened(
      ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.get() >= 0) ::fsync(opened.get());
}

// How long a pipe is waited for.
constexpr int kPipeSeconds = 5;

// Whether the pipe has something to read, or has been closed by its writer.
bool IsWrittenTo(int fd) {
  pollfd pipe = {.fd = fd, .events = POLLIN, .revents = 0};
  return ::poll(&pipe, 1, 1000 * kPipeSeconds) != 0;
}

// The content of an open file of about `size_hint` bytes.
absl::StatusOr<std::string> ReadAll(int fd, std::size_t size_hint,
                                    const std::string& path) {
  constexpr std::size_t kChunk = 1 << 16;
  std::string content;
  std::size_t filled = 0;
  content.resize(size_hint + 1);
  while (true) {
    if (filled == content.size()) content.resize(2 * content.size() + kChunk);
    const ssize_t got =
        ::read(fd, content.data() + filled, content.size() - filled);
    if (got < 0) {
      if (errno == EINTR) continue;
      return ErrnoStatus("cannot read", path);
    }
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
  }
  content.resize(filled);
  return content;
}

}  // namespace

absl::Status CheckRegularFile(const std::string& path) {
  struct stat info = {};
  if (::stat(path.c_str(), &info) != 0) {
    return ErrnoStatus("cannot open", path);
  }
  if (S_ISREG(info.st_mode)) return absl::OkStatus();
  return InvalidArgument("cannot read '", path,
                         S_ISDIR(info.st_mode)
                             ? "': it is a folder, not a file"
                             : "': it must be a regular file, as it is read "
                               "twice, or - for standard input");
}

absl::StatusOr<std::string> ReadFile(const std::string& path) {
  // Without O_NONBLOCK opening a pipe waits for a writer, without an end.
  const Descriptor file(
      ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) return ErrnoStatus("cannot open", path);
  struct stat info = {};
  if (::fstat(file.get(), &info) != 0 || ::fcntl(file.get(), F_SETFL, 0) != 0) {
    return ErrnoStatus("cannot read", path);
  }
  if (S_ISDIR(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot read '", path, "': it is a folder, not a file"));
  }
  // Devices such as /dev/zero have no end.
  if (!S_ISREG(info.st_mode) && !S_ISFIFO(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot read '", path, "': it is not a regular file"));
  }
  if (S_ISFIFO(info.st_mode) && !IsWrittenTo(file.get())) {
    return absl::FailedPreconditionError(absl::StrCat(
        "cannot read '", path, "': it is a pipe that nobody wrote to within ",
        kPipeSeconds, " s"));
  }
  try {
    return ReadAll(file.get(), static_cast<std::size_t>(info.st_size), path);
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      "cannot read '", path, "': it does not fit into the memory"));
}

absl::Status WriteFileAtomically(const std::string& path,
                                 std::string_view content) {
  MLE_RETURN_IF_ERROR(CheckReplaceable(path));
  StagedFile file(path);
  absl::Status status = file.Write(content);
  if (status.ok()) status = file.Commit();
  if (!status.ok()) return CannotWrite(path, status);
  SyncFolder(FolderOf(path));
  return absl::OkStatus();
}

absl::Status WriteFilesTogether(
    const std::string& folder,
    const std::vector<std::pair<std::string, std::string>>& files,
    const std::vector<std::string>& obsolete) {
  std::vector<StagedFile> staged;
  staged.reserve(files.size() + obsolete.size());
  for (const auto& [name, content] : files) {
    const std::string path = absl::StrCat(folder, "/", name);
    MLE_RETURN_IF_ERROR(CheckReplaceable(path));
    const absl::Status status = staged.emplace_back(path).Write(content);
    if (!status.ok()) return CannotWrite(path, status);
  }
  for (const std::string& name : obsolete) {
    staged.emplace_back(absl::StrCat(folder, "/", name));
  }
  for (StagedFile& file : staged) file.KeepOld();
  absl::Status status;
  for (std::size_t i = 0; i < staged.size() && status.ok(); ++i) {
    status = i < files.size() ? staged[i].Commit() : staged[i].Remove();
    if (!status.ok()) status = CannotWrite(staged[i].path(), status);
  }
  if (!status.ok()) {
    for (StagedFile& file : staged) file.TakeBack();
  }
  SyncFolder(folder);
  return status;
}

absl::Status CheckNothingInTheWay(const std::string& folder,
                                  const std::vector<std::string>& extensions) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string extension = entry.path().extension().string();
    if (std::find(extensions.begin(), extensions.end(), extension) !=
        extensions.end()) {
      MLE_RETURN_IF_ERROR(CheckReplaceable(entry.path().string()));
    }
  }
  return absl::OkStatus();
}

void RemoveLeftovers(const std::string& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (IsTemporary(entry.path().filename().string())) {
      left.push_back(entry.path());
    }
  }
  for (const std::filesystem::path& path : left) ::unlink(path.c_str());
}

absl::Status MakeWritableFolder(const std::string& path) {
  if (path.empty()) {
    return absl::InvalidArgumentError("cannot make a folder without a name");
  }
  std::error_code error;
  std::filesystem::create_directories(path, error);
  struct stat info = {};
  const bool exists = ::stat(path.c_str(), &info) == 0;
  if (exists && !S_ISDIR(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot make the folder '", path,
                     "': a file of that name is there already"));
  }
  if (!exists) {
    const int code = error ? error.value() : errno;
    return absl::ErrnoToStatus(
        code, absl::StrCat("cannot make the folder '", path, "'"));
  }
  const std::string probe = TemporaryName(path + "/probe");
  absl::Status status;
  {
    const Descriptor file(
        ::open(probe.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.get() < 0) status = ErrnoStatus("cannot create", probe);
  }
  ::unlink(probe.c_str());
  if (!status.ok()) {
    return absl::Status(status.code(),
                        absl::StrCat("cannot make files in the folder '", path,
                                     "': ", status.message()));
  }
  return absl::OkStatus();
}

}  // namespace mle
