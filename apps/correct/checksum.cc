#include "apps/correct/checksum.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "apps/common/sha256.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/historian.h"

namespace mle::correct {

absl::StatusOr<FileChecksum> ChecksumOf(const std::string& path) {
  if (path == "-") {
    Sha256 hash;
    hash.Add(StandardInput());
    return FileChecksum{hash.HexDigest(),
                        static_cast<std::int64_t>(StandardInput().size())};
  }
  MLE_RETURN_IF_ERROR(CheckRegularFile(path));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      std::fopen(path.c_str(), "rb"), &std::fclose);
  if (file == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat("cannot open '", path, "'"));
  }
  Sha256 hash;
  FileChecksum result;
  std::array<char, 1 << 16> block;
  while (true) {
    const std::size_t size =
        std::fread(block.data(), 1, block.size(), file.get());
    if (size == 0) break;
    result.bytes += static_cast<std::int64_t>(size);
    hash.Add(std::string_view(block.data(), size));
  }
  if (std::ferror(file.get()) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("cannot read '", path, "'"));
  }
  result.sha256 = hash.HexDigest();
  if (result.sha256.empty()) {
    return absl::InternalError(
        absl::StrCat("the checksum of '", path, "' could not be computed"));
  }
  return result;
}

}  // namespace mle::correct
