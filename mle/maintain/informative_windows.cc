#include "mle/maintain/informative_windows.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/maintain/segment_information.h"
#include "mle/maintain/whole_windows.h"

namespace mle {
namespace {

using Eigen::VectorXd;

// Parts of a long window: so many fit into the budget.
constexpr int kPartsOfBudget = 10;

int SamplesOf(const std::vector<SetPointWindow>& windows) {
  int samples = 0;
  for (const SetPointWindow& window : windows) {
    samples += window.record.samples();
  }
  return samples;
}

// Windows longer than one and a half times `length` samples in equal parts.
std::vector<SetPointWindow> Divided(std::vector<SetPointWindow> windows,
                                    int length) {
  std::vector<SetPointWindow> parts;
  for (SetPointWindow& window : windows) {
    const int samples = window.record.samples();
    const int count =
        std::max(1, static_cast<int>(std::lround(static_cast<double>(samples) /
                                                 static_cast<double>(length))));
    if (count == 1) {
      parts.push_back(std::move(window));
      continue;
    }
    for (int c = 0; c < count; ++c) {
      const auto at = [&](int part) {
        return static_cast<int>(static_cast<long long>(samples) * part / count);
      };
      SetPointWindow& part = parts.emplace_back(window);
      Cut({.first = at(c), .last = at(c + 1) - 1}, part);
      part.clipped_before = c > 0 || window.clipped_before;
      part.clipped_after = c + 1 < count || window.clipped_after;
      if (c > 0) part.before.clear();
      if (c + 1 < count) part.after.clear();
    }
  }
  return parts;
}

// Windows `first` to `end` − 1, taken or left together.
struct Run {
  std::size_t first = 0;
  std::size_t end = 0;
  int samples = 0;
};

// Windows that adjoin, together until they are `length` samples long; what is
// left of them at last belongs to what comes before it.
std::vector<Run> RunsOf(const std::vector<SetPointWindow>& windows,
                        int length) {
  std::vector<Run> runs;
  for (std::size_t w = 0; w < windows.size();) {
    const std::size_t begin = runs.size();
    bool adjoins = true;
    while (adjoins) {
      Run run{.first = w, .end = w};
      do {
        run.samples += windows[run.end].record.samples();
        ++run.end;
        adjoins = run.end < windows.size() &&
                  Adjoin(windows[run.end - 1], windows[run.end]);
      } while (adjoins && run.samples < length);
      w = run.end;
      if (run.samples < length && runs.size() > begin) {
        runs.back().end = run.end;
        runs.back().samples += run.samples;
      } else {
        runs.push_back(run);
      }
    }
  }
  return runs;
}

}  // namespace

absl::Status KeepInformativeWindows(const ProcessModel& model, int most_samples,
                                    RecordData& data) {
  if (most_samples <= 0 || SamplesOf(data.windows) <= most_samples) {
    return absl::OkStatus();
  }
  const int length = std::max(most_samples / kPartsOfBudget,
                              ShortestSegment(model, data.sample_time()));
  std::vector<SetPointWindow> windows =
      Divided(std::move(data.windows), length);
  std::vector<SegmentInformation> segments;  // of the runs
  const std::vector<Run> runs = RunsOf(windows, length);
  for (const Run& run : runs) {
    SegmentInformation& segment = segments.emplace_back();
    for (std::size_t w = run.first; w < run.end; ++w) {
      MLE_ASSIGN_OR_RETURN(const SegmentInformation of,
                           InformationIn(windows[w].record, model));
      if (w == run.first) segment.information.setZero(of.information.size());
      segment.information += of.information;
      segment.samples += of.samples;
    }
  }
  VectorXd all = VectorXd::Zero(segments[0].information.size());
  for (const SegmentInformation& segment : segments) {
    all += segment.information;
  }
  const std::vector<bool> taken = ChooseSegments(segments, all, most_samples);
  const int samples = SamplesOf(windows);
  VectorXd used = VectorXd::Zero(all.size());
  data.windows.clear();
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (taken[r]) used += segments[r].information;
    for (std::size_t w = runs[r].first; w < runs[r].end; ++w) {
      if (taken[r]) {
        data.windows.push_back(std::move(windows[w]));
      } else {
        data.unused.push_back({.source = windows[w].source,
                               .first_sample = windows[w].first_sample,
                               .samples = windows[w].record.samples()});
      }
    }
  }
  if (data.unused.empty()) return absl::OkStatus();
  data.notes.push_back(
      {MessageCode::kWindowDropped,
       "",
       absl::StrFormat("Of %d windows or parts of windows %d are used, the "
                       "most informative: %d of %d samples. %s",
                       static_cast<int>(windows.size()),
                       static_cast<int>(data.windows.size()),
                       SamplesOf(data.windows), samples,
                       DescribeLoss(used, all)),
       {"most_samples"}});
  return absl::OkStatus();
}

}  // namespace mle
