#include "apps/common/progress.h"

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/clean_output.h"
#include "apps/report/text.h"

namespace mle {
namespace {

constexpr double kFirst = 2.0;            // s
constexpr double kBetweenLines = 10.0;    // s, in a log
constexpr double kBetweenRewrites = 0.1;  // s, on a terminal

double Now() {
  return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

bool ErrorsGoToTerminal() {
  const char* const kind = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && kind != nullptr &&
         std::string_view(kind) != "dumb";
}

std::mutex& LineMutex() {
  static auto* const kMutex = new std::mutex;
  return *kMutex;
}

StatusLine& TheLine() {
  static auto* const kErrors = new std::ostream(UncleanErrors());
  static auto* const kLine =
      new StatusLine(*kErrors, ErrorsGoToTerminal(), Now());
  return *kLine;
}

// ", about 40 s left" after `seconds` in which a share of the work was done.
std::string TimeLeft(double seconds, double done) {
  if (!(done > 0.0)) return "";
  return absl::StrCat(", about ",
                      SpelledDuration(seconds / done * (1.0 - done)), " left");
}

}  // namespace

StatusLine::StatusLine(std::ostream& out, bool terminal, double now)
    : out_(out),
      terminal_(terminal),
      due_(now + (terminal ? kFirst : kBetweenLines)) {}

void StatusLine::Show(const std::string& text, double now) {
  if (now < due_) return;
  due_ = now + (terminal_ ? kBetweenRewrites : kBetweenLines);
  if (!terminal_) {
    out_ << report::CleanText(text) << "\n";
    return;
  }
  // To the line's begin; what is right of the text is erased.
  out_ << "\r" << report::CleanText(text) << "\x1b[K" << std::flush;
  shown_ = true;
}

void StatusLine::End() {
  if (shown_) out_ << "\r\x1b[K" << std::flush;
  shown_ = false;
}

void ShowStatus(const std::string& text) {
  const std::lock_guard<std::mutex> lock(LineMutex());
  TheLine().Show(text, Now());
}

void EndStatus() {
  const std::lock_guard<std::mutex> lock(LineMutex());
  TheLine().End();
}

std::string SpelledDuration(double seconds) {
  if (seconds < 100.0) return absl::StrFormat("%.0f s", seconds);
  if (seconds < 6000.0) return absl::StrFormat("%.0f min", seconds / 60.0);
  return absl::StrFormat("%.1f h", seconds / 3600.0);
}

ProgressFunction ShowProgress(std::string what) {
  // Steady, because the system clock may be set while the command runs.
  using Clock = std::chrono::steady_clock;
  struct Shown {
    std::once_flag begun;
    std::int64_t before = 0;
    Clock::time_point start;
    ~Shown() { EndStatus(); }
  };
  return [what = std::move(what), shown = std::make_shared<Shown>()](
             std::int64_t done, std::int64_t total) {
    std::call_once(shown->begun, [&] {
      shown->before = done;
      shown->start = Clock::now();
    });
    if (done >= total) return EndStatus();
    std::string text = absl::StrCat(what, ": ", done, " of ", total);
    const double seconds =
        std::chrono::duration<double>(Clock::now() - shown->start).count();
    ShowStatus(text + TimeLeft(seconds,
                               static_cast<double>(done - shown->before) /
                                   static_cast<double>(total - shown->before)));
  };
}

std::function<void(const std::string& stage, double fraction)> ShowStages() {
  return [last = std::string(), start = 0.0](const std::string& stage,
                                             double fraction) mutable {
    if (stage != last) {
      last = stage;
      start = Now();
    }
    ShowStatus(fraction == 0.0
                   ? stage
                   : absl::StrFormat("%s: %.0f %%%s", stage, 100.0 * fraction,
                                     TimeLeft(Now() - start, fraction)));
  };
}

}  // namespace mle
