#include "mle/maintain/informative_windows.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/whole_windows.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/innovations_filter.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// q/r of the drift that is expected.
constexpr double kDriftRatio = 1e-3;
// Of all information on an element: more than this counts little less.
constexpr double kLittle = 1e-3;
// Parts of a long window: as many fit into the budget, and none is shorter than
// so many settling times.
constexpr int kPartsOfBudget = 10;
constexpr double kShortestPart = 4.0;

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

// I_w of all elements that are present, one after the other.
absl::StatusOr<VectorXd> InformationOf(const ProcessModel& model,
                                       const Record& window) {
  const Record whole = WithoutGaps(window);
  std::vector<int> times(whole.samples());
  std::iota(times.begin(), times.end(), 0);
  const InnovationsFilter filter(times, {.ratio = kDriftRatio});
  std::vector<double> information;
  for (int j = 0; j < model.num_inputs(); ++j) {
    std::vector<int> present;
    std::vector<OutputChannel> outputs;
    for (int i = 0; i < model.num_outputs(); ++i) {
      if (model.element(i, j).IsZero()) continue;
      present.push_back(i);
      outputs.push_back(model.outputs()[i]);
    }
    if (present.empty()) continue;
    ProcessModel column("column", model.time_unit(), {model.inputs()[j]},
                        std::move(outputs));
    for (std::size_t i = 0; i < present.size(); ++i) {
      column.element(static_cast<int>(i), 0) = model.element(present[i], j);
    }
    MLE_ASSIGN_OR_RETURN(
        const MatrixXd response,
        SimulateResponse(column, whole.sample_time, whole.inputs.row(j)));
    MatrixXd whitened = response.transpose();
    filter.Apply(whitened);
    for (Index i = 0; i < whitened.cols(); ++i) {
      const double squares = whitened.col(i).squaredNorm();
      information.push_back(std::isfinite(squares) ? squares : 0.0);
    }
  }
  return VectorXd(Eigen::Map<const VectorXd>(
      information.data(), static_cast<Index>(information.size())));
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

// Column w: the windows taken, run by run, until `most_samples` are.
std::vector<bool> Choose(const MatrixXd& information,
                         const std::vector<Run>& runs, int most_samples) {
  const VectorXd all = information.rowwise().sum();
  VectorXd sum = (kLittle * all).cwiseMax(1e-300);
  std::vector<VectorXd> of_runs;
  for (const Run& run : runs) {
    of_runs.emplace_back(
        information
            .middleCols(static_cast<Index>(run.first),
                        static_cast<Index>(run.end - run.first))
            .rowwise()
            .sum());
  }
  std::vector<bool> taken(information.cols(), false);
  for (int left = most_samples; left > 0;) {
    double best = -1.0;
    std::size_t next = runs.size();
    for (std::size_t r = 0; r < runs.size(); ++r) {
      // The first is taken whatever its length.
      if (taken[runs[r].first] ||
          (runs[r].samples > left && left < most_samples)) {
        continue;
      }
      const double gain =
          (of_runs[r].array() / sum.array()).log1p().sum() / runs[r].samples;
      if (gain > best) {
        best = gain;
        next = r;
      }
    }
    if (next == runs.size()) break;
    for (std::size_t w = runs[next].first; w < runs[next].end; ++w) {
      taken[w] = true;
    }
    sum += of_runs[next];
    left -= runs[next].samples;
  }
  return taken;
}

// By how much standard errors of gains would be smaller with all windows.
std::vector<double> Losses(const MatrixXd& information,
                           const std::vector<bool>& taken) {
  std::vector<double> losses;
  for (Index e = 0; e < information.rows(); ++e) {
    double used = 0.0;
    for (std::size_t w = 0; w < taken.size(); ++w) {
      if (taken[w]) used += information(e, static_cast<Index>(w));
    }
    const double all = information.row(e).sum();
    if (all > 0.0) losses.push_back(1.0 - std::sqrt(used / all));
  }
  std::sort(losses.begin(), losses.end());
  return losses;
}

}  // namespace

absl::Status KeepInformativeWindows(const ProcessModel& model, int most_samples,
                                    RecordData& data) {
  if (most_samples <= 0 || SamplesOf(data.windows) <= most_samples) {
    return absl::OkStatus();
  }
  const double settling =
      std::min(kShortestPart * SettlingTime(model) / data.sample_time(), 1e9);
  const int length = std::max({most_samples / kPartsOfBudget,
                               static_cast<int>(std::ceil(settling)), 2});
  std::vector<SetPointWindow> windows =
      Divided(std::move(data.windows), length);
  const auto count = static_cast<Index>(windows.size());
  MatrixXd information;
  for (Index w = 0; w < count; ++w) {
    MLE_ASSIGN_OR_RETURN(const VectorXd of,
                         InformationOf(model, windows[w].record));
    if (w == 0) information.resize(of.size(), count);
    information.col(w) = of;
  }
  const std::vector<bool> taken =
      Choose(information, RunsOf(windows, length), most_samples);
  const int samples = SamplesOf(windows);
  data.windows.clear();
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (taken[w]) {
      data.windows.push_back(std::move(windows[w]));
    } else {
      data.unused.push_back({.source = windows[w].source,
                             .first_sample = windows[w].first_sample,
                             .samples = windows[w].record.samples()});
    }
  }
  if (data.unused.empty()) return absl::OkStatus();
  const std::vector<double> losses = Losses(information, taken);
  data.notes.push_back(
      {MessageCode::kWindowDropped,
       "",
       absl::StrFormat(
           "Of %d windows or parts of windows %d are used, the most "
           "informative: %d of %d samples. With all of them standard errors of "
           "gains would be expected to be smaller by %.0f %% in the median, by "
           "%.0f %% at most.",
           static_cast<int>(count), static_cast<int>(data.windows.size()),
           SamplesOf(data.windows), samples,
           losses.empty() ? 0.0 : 100.0 * losses[losses.size() / 2],
           losses.empty() ? 0.0 : 100.0 * losses.back()),
       {"most_samples"}});
  return absl::OkStatus();
}

}  // namespace mle
