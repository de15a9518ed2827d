// A number that changes slowly: piecewise linear in time, with steps.
//
// Between two points the value is interpolated; before the first and after the
// last it stays. Two points at one time are a step: the value jumps from the
// first to the second of them.
//
//   MLE_ASSIGN_OR_RETURN(
//       Schedule gain, Schedule::Create({{0.0, 1.0}, {1000.0, 0.8},
//                                        {1000.0, 0.5}}));
//   gain.At(500.0);   // 0.9
//   gain.At(1000.0);  // 0.5

#ifndef SIM_SCHEDULE_H_
#define SIM_SCHEDULE_H_

#include <vector>

#include "absl/status/statusor.h"

namespace mle::sim {

class Schedule {
 public:
  struct Point {
    double time = 0.0;
    double value = 0.0;
  };
  // value + slope · (t − time) for t near the time asked for.
  struct Line {
    double value = 0.0;
    double slope = 0.0;
  };

  explicit Schedule(double constant) : points_{{0.0, constant}} {}
  // Finite points, at least one, in order of time, at most two at one time;
  // slopes between them finite.
  static absl::StatusOr<Schedule> Create(std::vector<Point> points);

  const std::vector<Point>& points() const { return points_; }
  bool IsConstant() const;
  double Min() const;
  double Max() const;
  // The largest rate of change between points; −∞ for a constant.
  double MaxSlope() const;

  // At a step, the value after it.
  double At(double time) const { return LineAt(time).value; }
  Line LineAt(double time) const;

  // This schedule with `offset` added to every value.
  Schedule Shifted(double offset) const;

 private:
  std::vector<Point> points_;
};

}  // namespace mle::sim

#endif  // SIM_SCHEDULE_H_
