// One program at a time on a folder of results.
//
// The lock is flock(2) on the folder itself: no file is left behind, and the
// system releases the lock when its owner ends, also when it is killed.
//
//   MLE_ASSIGN_OR_RETURN(const FolderLock lock, FolderLock::Take("results"));

#ifndef MLE_BASE_FOLDER_LOCK_H_
#define MLE_BASE_FOLDER_LOCK_H_

#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace mle {

class FolderLock {
 public:
  // Locks an existing folder. Unavailable if another FolderLock of any process
  // on this machine holds it; NotFound or the like if it cannot be opened. A
  // file system without locks grants the lock to every caller.
  static absl::StatusOr<FolderLock> Take(const std::string& folder);

  FolderLock(FolderLock&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace mle

#endif  // MLE_BASE_FOLDER_LOCK_H_
