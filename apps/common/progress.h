// The progress of a long run, on standard error: on a terminal one line that is
// rewritten, in a log a line every ten seconds. Runs that are done within two
// seconds say nothing.
//
//   Progress progress("runs", 40);
//   … progress.Done();                   // from any thread
//
//   ShowStatus("fitting 4 windows");     // for what has no parts
//   EndStatus();                         // before anything else is printed

#ifndef APPS_COMMON_PROGRESS_H_
#define APPS_COMMON_PROGRESS_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <ostream>
#include <string>

namespace mle {

// Where a status is written, and how often. Times are seconds since any moment.
class StatusLine {
 public:
  // `terminal`: the line is rewritten.
  StatusLine(std::ostream& out, bool terminal, double now);

  void Show(const std::string& text, double now);
  // Leaves an empty line, for other messages.
  void End();

 private:
  std::ostream& out_;
  const bool terminal_;
  double due_;          // before which nothing is written
  bool shown_ = false;  // something stands in the line
};

// The one line of the program, on standard error; may be called from any
// thread.
void ShowStatus(const std::string& text);
void EndStatus();

// "40 s", "7 min", "3.5 h".
std::string SpelledDuration(double seconds);

// A run of many parts: how many are done and how long the others may take.
class Progress {
 public:
  // `before` parts were done by a former run.
  Progress(std::string what, std::int64_t total, std::int64_t before = 0);
  ~Progress() { EndStatus(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // One more part is done, or `done` of them are; may be called from any
  // thread.
  void Done();
  void Show(std::int64_t done);

 private:
  // Steady, because the system clock may be set while the command runs.
  using Clock = std::chrono::steady_clock;
  const std::string what_;
  const std::int64_t total_;
  const std::int64_t before_;
  const Clock::time_point start_;
  std::mutex mutex_;
  std::int64_t done_;
};

// How work tells that so many of its parts are done; may be called from any
// thread.
using ProgressFunction =
    std::function<void(std::int64_t done, std::int64_t total)>;

// Shows what it is told, from the first call on and as long as it lives.
ProgressFunction ShowProgress(std::string what);

}  // namespace mle

#endif  // APPS_COMMON_PROGRESS_H_
