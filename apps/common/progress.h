// Progress of a run of many parts, on standard error: nothing for the first two
// seconds, then at most one line a second.

#ifndef APPS_COMMON_PROGRESS_H_
#define APPS_COMMON_PROGRESS_H_

#include <chrono>
#include <mutex>
#include <string>

namespace mle {

class Progress {
 public:
  Progress(std::string what, int total);

  // One more part is done; may be called from any thread.
  void Done();

 private:
  const std::string what_;
  const int total_;
  // Steady, because the system clock may be set while the command runs.
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start_;
  std::mutex mutex_;
  int done_ = 0;
  Clock::time_point last_print_;
};

}  // namespace mle

#endif  // APPS_COMMON_PROGRESS_H_
