#include "mle/base/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

#include "absl/strings/str_cat.h"
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

// A new file with this content, on the disk before this returns.
absl::Status WriteNewFile(const std::string& path, std::string_view content) {
  Descriptor file(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (file.get() < 0) return ErrnoStatus("cannot create", path);
  MLE_RETURN_IF_ERROR(WriteAll(file.get(), content, path));
  if (::fsync(file.get()) != 0) return ErrnoStatus("cannot sync", path);
  if (file.Close() != 0) return ErrnoStatus("cannot close", path);
  return absl::OkStatus();
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

absl::StatusOr<std::string> ReadFile(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return ErrnoStatus("cannot open", path);
  struct stat info = {};
  if (::fstat(file.get(), &info) != 0) return ErrnoStatus("cannot read", path);
  if (S_ISDIR(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot read '", path, "': it is a folder, not a file"));
  }
  // Devices such as /dev/zero have no end.
  if (!S_ISREG(info.st_mode) && !S_ISFIFO(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot read '", path, "': it is not a regular file"));
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
  if (path.empty()) {
    return absl::InvalidArgumentError("cannot write a file without a name");
  }
  // Renaming would replace a device or a pipe by a file.
  struct stat info = {};
  if (::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot write '", path,
                     S_ISDIR(info.st_mode) ? "': it is a folder"
                                           : "': it is not a regular file"));
  }
  const std::string temporary = TemporaryName(path);
  absl::Status status = WriteNewFile(temporary, content);
  if (status.ok() && std::rename(temporary.c_str(), path.c_str()) != 0) {
    status = ErrnoStatus("cannot replace", path);
  }
  if (!status.ok()) {
    ::unlink(temporary.c_str());
    return absl::Status(status.code(), absl::StrCat("cannot write '", path,
                                                    "': ", status.message()));
  }
  return absl::OkStatus();
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
  const absl::Status status = WriteNewFile(probe, "");
  ::unlink(probe.c_str());
  if (!status.ok()) {
    return absl::Status(status.code(),
                        absl::StrCat("cannot make files in the folder '", path,
                                     "': ", status.message()));
  }
  return absl::OkStatus();
}

}  // namespace mle
