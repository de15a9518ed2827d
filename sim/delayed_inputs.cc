#include "sim/delayed_inputs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle::sim {
namespace {

constexpr double kMaxDelaySamples = 1e7;

absl::Status CheckPath(const InputPath& path, int num_inputs,
                       double sample_time) {
  if (path.input < 0 || path.input >= num_inputs) {
    return InvalidArgument("input = ", path.input,
                           ", but it must be one of 0 … ", num_inputs - 1);
  }
  if (!(path.delay.Min() >= 0.0)) {
    return InvalidArgument("the dead time falls to ", path.delay.Min(),
                           "; it must not be negative");
  }
  if (!(path.delay.Max() / sample_time <= kMaxDelaySamples)) {
    return InvalidArgument("the delay of ", path.delay.Max(), " is more than ",
                           kMaxDelaySamples, " samples of ", sample_time,
                           "; use a longer sample time");
  }
  if (!(path.delay.MaxSlope() < 1.0)) {
    return InvalidArgument(
        "the dead time grows by ", path.delay.MaxSlope(),
        " per unit of time; it must grow slower than time itself (< 1)");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DelayedInputs> DelayedInputs::Create(
    int num_inputs, std::vector<InputPath> paths, double sample_time) {
  double longest = 0.0;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const absl::Status status = CheckPath(paths[i], num_inputs, sample_time);
    if (!status.ok()) {
      return InvalidArgument("path ", i + 1, ": ", status.message());
    }
    longest = std::max(longest, paths[i].delay.Max() / sample_time);
  }
  DelayedInputs inputs;
  inputs.sample_time_ = sample_time;
  inputs.paths_ = std::move(paths);
  inputs.history_ =
      Eigen::MatrixXd::Zero(num_inputs, static_cast<int>(longest) + 2);
  inputs.events_.reserve(4 * inputs.paths_.size());
  return inputs;
}

void DelayedInputs::Hold(double time,
                         const Eigen::Ref<const Eigen::VectorXd>& input) {
  CHECK_EQ(input.size(), history_.rows());
  newest_ = newest_ + 1 == history_.cols() ? 0 : newest_ + 1;
  history_.col(newest_) = input;
  events_.clear();
  for (int path = 0; path < num_paths(); ++path) AddEvents(time, path);
  std::sort(events_.begin(), events_.end(),
            [](const Event& a, const Event& b) { return a.at < b.at; });
}

// The schedule's points cut the sample into pieces in which L is linear.
void DelayedInputs::AddEvents(double time, int path) {
  const std::vector<Schedule::Point>& points = paths_[path].delay.points();
  double from = 0.0;
  if (points.size() > 1) {
    auto point = std::lower_bound(
        points.begin(), points.end(), time,
        [](const Schedule::Point& p, double t) { return p.time < t; });
    for (; point != points.end(); ++point) {
      const double at = (point->time - time) / sample_time_;
      if (at >= 1.0 - kSnap) break;
      if (at <= from + kSnap) continue;
      AddEventsOfPiece(time, path, from, at);
      from = at;
    }
  }
  AddEventsOfPiece(time, path, from, 1.0);
}

// With s in samples after the present one, the path carries the input that
// began at g(s) = s − L/Δt: of sample ⌊g⌋, which changes where g is whole.
void DelayedInputs::AddEventsOfPiece(double time, int path, double from,
                                     double to) {
  const double middle = 0.5 * (from + to);
  const Schedule::Line delay =
      paths_[path].delay.LineAt(time + middle * sample_time_);
  const double slope = 1.0 - delay.slope;  // dg/ds
  const double at_middle = middle - delay.value / sample_time_;
  const double start = at_middle - slope * (middle - from);
  const double end = at_middle + slope * (to - middle);

  double whole = std::floor(start + kSnap);
  const auto age = [&whole] { return static_cast<int>(std::max(0.0, -whole)); };
  events_.push_back({from, path, age()});
  for (whole += 1.0; end - whole > kSnap; whole += 1.0) {
    events_.push_back({from + (whole - start) / slope, path, age()});
  }
}

double DelayedInputs::Value(const Event& event) const {
  // A snap may round an age up past the longest dead time.
  const int depth = static_cast<int>(history_.cols());
  const int column = newest_ - std::min(event.age, depth - 1);
  return history_(paths_[event.path].input,
                  column < 0 ? column + depth : column);
}

}  // namespace mle::sim
