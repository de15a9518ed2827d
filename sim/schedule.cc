#include "sim/schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mle/base/status.h"

namespace mle::sim {
namespace {

bool LessValue(const Schedule::Point& a, const Schedule::Point& b) {
  return a.value < b.value;
}

double SlopeBetween(const Schedule::Point& a, const Schedule::Point& b) {
  return (b.value - a.value) / (b.time - a.time);
}

}  // namespace

absl::StatusOr<Schedule> Schedule::Create(std::vector<Point> points) {
  if (points.empty()) {
    return absl::InvalidArgumentError(
        "the schedule is empty, it needs at least one point");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& point = points[i];
    if (!std::isfinite(point.time) || !std::isfinite(point.value)) {
      return InvalidArgument("point ", i + 1, " is (", point.time, ", ",
                             point.value, "); time and value must be finite");
    }
    if (i >= 1 && point.time < points[i - 1].time) {
      return InvalidArgument("point ", i + 1, " is at time ", point.time,
                             ", the one before at ", points[i - 1].time,
                             "; points must be in order of time");
    }
    if (i >= 2 && point.time == points[i - 2].time) {
      return InvalidArgument(
          "three points are at time ", point.time,
          "; a step has two, the value before it and the one after");
    }
    if (i >= 1 && point.time > points[i - 1].time &&
        !(std::isfinite(point.time - points[i - 1].time) &&
          std::isfinite(SlopeBetween(points[i - 1], point)))) {
      return InvalidArgument(
          "between points ", i, " and ", i + 1, ", (", points[i - 1].time, ", ",
          points[i - 1].value, ") and (", point.time, ", ", point.value,
          "), time or slope is not finite; a step is two points at one time");
    }
  }
  Schedule schedule(0.0);
  schedule.points_ = std::move(points);
  return schedule;
}

bool Schedule::IsConstant() const { return Min() == Max(); }

double Schedule::Min() const {
  return std::min_element(points_.begin(), points_.end(), LessValue)->value;
}

double Schedule::Max() const {
  return std::max_element(points_.begin(), points_.end(), LessValue)->value;
}

double Schedule::MaxSlope() const {
  double slope = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < points_.size(); ++i) {
    if (points_[i].time == points_[i - 1].time) continue;
    slope = std::max(slope, SlopeBetween(points_[i - 1], points_[i]));
  }
  return slope;
}

Schedule::Line Schedule::LineAt(double time) const {
  const auto next = std::upper_bound(
      points_.begin(), points_.end(), time,
      [](double t, const Point& point) { return t < point.time; });
  if (next == points_.begin()) return {points_.front().value, 0.0};
  if (next == points_.end()) return {points_.back().value, 0.0};
  const Point& before = *std::prev(next);
  const double slope = SlopeBetween(before, *next);
  return {before.value + slope * (time - before.time), slope};
}

Schedule Schedule::Shifted(double offset) const {
  Schedule shifted = *this;
  for (Point& point : shifted.points_) point.value += offset;
  return shifted;
}

}  // namespace mle::sim
