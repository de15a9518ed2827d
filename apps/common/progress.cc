#include "apps/common/progress.h"

#include <iostream>
#include <utility>

#include "absl/strings/str_format.h"
#include "absl/time/clock.h"

namespace mle {

Progress::Progress(std::string what, int total)
    : what_(std::move(what)),
      total_(total),
      start_(absl::Now()),
      last_print_(start_ + absl::Seconds(1)) {}

void Progress::Done() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++done_;
  const absl::Time now = absl::Now();
  if (now - last_print_ < absl::Seconds(1) || done_ == total_) return;
  last_print_ = now;
  const double seconds = absl::ToDoubleSeconds(now - start_);
  std::cerr << absl::StrFormat("%s: %d of %d, about %.0f s left\n", what_,
                               done_, total_,
                               seconds / done_ * (total_ - done_));
}

}  // namespace mle
