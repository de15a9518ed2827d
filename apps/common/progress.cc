#include "apps/common/progress.h"

#include <iostream>
#include <utility>

#include "absl/strings/str_format.h"

namespace mle {

Progress::Progress(std::string what, int total)
    : what_(std::move(what)),
      total_(total),
      start_(Clock::now()),
      last_print_(start_ + std::chrono::seconds(1)) {}

void Progress::Done() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++done_;
  const Clock::time_point now = Clock::now();
  if (now - last_print_ < std::chrono::seconds(1) || done_ == total_) return;
  last_print_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  std::cerr << absl::StrFormat("%s: %d of %d, about %.0f s left\n", what_,
                               done_, total_,
                               seconds / done_ * (total_ - done_));
}

}  // namespace mle
