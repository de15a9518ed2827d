#include "apps/correct/checksum.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "openssl/evp.h"

namespace mle::correct {

absl::StatusOr<FileChecksum> ChecksumOf(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      std::fopen(path.c_str(), "rb"), &std::fclose);
  if (file == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat("cannot open '", path, "'"));
  }
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context(
      EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  bool good = context != nullptr &&
              EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1;
  FileChecksum result;
  std::array<unsigned char, 1 << 16> block;
  while (good) {
    const std::size_t size =
        std::fread(block.data(), 1, block.size(), file.get());
    if (size == 0) break;
    result.bytes += static_cast<std::int64_t>(size);
    good = EVP_DigestUpdate(context.get(), block.data(), size) == 1;
  }
  if (std::ferror(file.get()) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("cannot read '", path, "'"));
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned int length = 0;
  if (!good || EVP_DigestFinal_ex(context.get(), digest.data(), &length) != 1) {
    return absl::InternalError(
        absl::StrCat("the checksum of '", path, "' could not be computed"));
  }
  for (unsigned int i = 0; i < length; ++i) {
    absl::StrAppendFormat(&result.sha256, "%02x", digest[i]);
  }
  return result;
}

}  // namespace mle::correct
