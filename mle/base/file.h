// Files read and written whole.
//
// WriteFileAtomically writes to a temporary file in the same folder, flushes it
// to the disk and renames it, so that a reader sees the old content or the new,
// never a part.

#ifndef MLE_BASE_FILE_H_
#define MLE_BASE_FILE_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle {

// The bytes of `path`. NotFound or PermissionDenied name the path and why.
absl::StatusOr<std::string> ReadFile(const std::string& path);

// Replaces `path` by `content`, whole or not at all.
absl::Status WriteFileAtomically(const std::string& path,
                                 std::string_view content);

// Makes `path` and its parents; fails if it exists and is no folder, or if
// files cannot be made in it.
absl::Status MakeWritableFolder(const std::string& path);

}  // namespace mle

#endif  // MLE_BASE_FILE_H_
