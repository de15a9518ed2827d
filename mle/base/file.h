// Files read and written whole.
//
// WriteFileAtomically writes to a temporary file in the same folder, flushes it
// to the disk and renames it, so that a reader sees the old content or the new,
// never a part. WriteFilesTogether does so for all files of a result: the first
// takes its name once the last is on the disk, and a file that cannot be
// replaced gives those before it their old content back, so that a full disk,
// a kill or a protected file leaves the old result.
//
//   MLE_RETURN_IF_ERROR(WriteFilesTogether(
//       "correction", {{"result.json", json}, {"report.html", page}}));

#ifndef MLE_BASE_FILE_H_
#define MLE_BASE_FILE_H_

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle {

// The bytes of `path`. NotFound or PermissionDenied name the path and why.
absl::StatusOr<std::string> ReadFile(const std::string& path);

// An error unless `path` is a regular file: what is read twice must be one, and
// pipes without a writer and devices without an end would be read for ever.
absl::Status CheckRegularFile(const std::string& path);

// Replaces `path` by `content`, whole or not at all.
absl::Status WriteFileAtomically(const std::string& path,
                                 std::string_view content);

// Replaces the files of these names in `folder` by these contents, and removes
// those named `obsolete`, where there are any. All or nothing: only a kill
// between the final renames, which need no disk space, or a file system without
// hard links can leave some old and some new.
absl::Status WriteFilesTogether(
    const std::string& folder,
    const std::vector<std::pair<std::string, std::string>>& files,
    const std::vector<std::string>& obsolete = {});

// An error that names what in `folder` has a name ending in one of these
// extensions (".json") but is not a regular file: a folder, a pipe, a device,
// which no file can replace.
absl::Status CheckNothingInTheWay(const std::string& folder,
                                  const std::vector<std::string>& extensions);

// Removes what writers that were killed have left in `folder`. No other process
// may be writing there (folder_lock.h).
void RemoveLeftovers(const std::string& folder);

// Makes `path` and its parents; fails if `path` exists and is not a
// folder, or if files cannot be created in it.
absl::Status MakeWritableFolder(const std::string& path);

}  // namespace mle

#endif  // MLE_BASE_FILE_H_
