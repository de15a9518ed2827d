// SHA-256 (FIPS 180-4) of a file, so that a result can be tied to what it was
// made from.

#ifndef APPS_CORRECT_CHECKSUM_H_
#define APPS_CORRECT_CHECKSUM_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace mle::correct {

struct FileChecksum {
  std::string sha256;  // 64 hexadecimal digits
  std::int64_t bytes = 0;
};

// Reads the file block by block; of "-" what standard input had. Errors name
// the path.
absl::StatusOr<FileChecksum> ChecksumOf(const std::string& path);

}  // namespace mle::correct

#endif  // APPS_CORRECT_CHECKSUM_H_
