#include "mle/maintain/leave_out.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/option_error.h"

namespace mle {
namespace {

bool Contains(const SetPointWindow& window, double time) {
  return BeginOf(window) <= time && time <= EndOf(window);
}

absl::Status NoSuchWindow(const TimeNames& names, double time,
                          const RecordData& data) {
  std::vector<std::string> spans;
  for (const SetPointWindow& window : data.windows) {
    spans.push_back(names.Span(BeginOf(window), EndOf(window)));
  }
  return OptionError(
      "leave_out",
      absl::StrCat("leave_out: no window contains ", names.At(time),
                   "; the windows are ", absl::StrJoin(spans, ", ")));
}

}  // namespace

absl::Status LeaveOutWindows(const ProcessModel& model,
                             const std::vector<double>& times,
                             RecordData& data) {
  if (times.empty()) return absl::OkStatus();
  const TimeNames names = data.Times(model);
  std::vector<bool> out(data.windows.size(), false);
  for (const double time : times) {
    bool found = false;
    for (std::size_t w = 0; w < data.windows.size(); ++w) {
      if (!Contains(data.windows[w], time)) continue;
      out[w] = found = true;
    }
    if (!found) return NoSuchWindow(names, time, data);
  }
  if (std::count(out.begin(), out.end(), false) == 0) {
    return OptionError("leave_out",
                       "leave_out leaves no window of the records");
  }
  std::vector<SetPointWindow> kept;
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    SetPointWindow& window = data.windows[w];
    if (!out[w]) {
      kept.push_back(std::move(window));
      continue;
    }
    data.notes.push_back(
        {MessageCode::kWindowDropped,
         "",
         absl::StrCat("The window ", names.Span(BeginOf(window), EndOf(window)),
                      " is left out, as asked for."),
         {"leave_out"}});
  }
  data.windows = std::move(kept);
  return absl::OkStatus();
}

}  // namespace mle
