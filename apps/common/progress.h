// The progress of a long run, on standard error: on a terminal one line that is
// rewritten, in a log a line every ten seconds. Runs that are done within two
// seconds say nothing.
//
//   const ProgressFunction told = ShowProgress("runs");
//   … told(done, 40);                    // from any thread
//
//   ShowStatus("fitting 4 windows");     // for what has no parts
//   EndStatus();                         // before anything else is printed

#ifndef APPS_COMMON_PROGRESS_H_
#define APPS_COMMON_PROGRESS_H_

#include <cstdint>
#include <functional>
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

// How work tells that so many of its parts are done; may be called from any
// thread.
using ProgressFunction =
    std::function<void(std::int64_t done, std::int64_t total)>;

// Shows what it is told, and how long the others may take, from the first call
// on and as long as it lives. What is done then was done by a former run.
ProgressFunction ShowProgress(std::string what);

// Shows the stages of a run, how much of each is done and how long it may still
// take; one call at a time.
std::function<void(const std::string& stage, double fraction)> ShowStages();

}  // namespace mle

#endif  // APPS_COMMON_PROGRESS_H_
