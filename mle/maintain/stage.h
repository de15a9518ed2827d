// A stage of a run, which reports its progress. Internal to this project.

#ifndef MLE_MAINTAIN_STAGE_H_
#define MLE_MAINTAIN_STAGE_H_

#include <mutex>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "mle/maintain/message.h"

namespace mle {

// One stage of `total` parts. Done() may be called from any thread.
class Stage {
 public:
  Stage(const ProgressCallback& callback, std::string name, int total = 1)
      : callback_(callback), total_(total) {
    progress_.stage = std::move(name);
    Report();
  }

  void Done() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++done_;
    progress_.fraction = static_cast<double>(done_) / total_;
    if (total_ > 1) Report();
  }

  // Parts that have not begun need not be done any more.
  bool cancelled() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return cancelled_;
  }

  absl::Status status() const {
    return cancelled() ? absl::CancelledError("stopped by the caller while " +
                                              progress_.stage)
                       : absl::OkStatus();
  }

 private:
  void Report() {
    if (callback_ && !cancelled_) cancelled_ = !callback_(progress_);
  }

  const ProgressCallback& callback_;
  const int total_;
  RunProgress progress_;
  int done_ = 0;
  bool cancelled_ = false;
  mutable std::mutex mutex_;
};

}  // namespace mle

#endif  // MLE_MAINTAIN_STAGE_H_
