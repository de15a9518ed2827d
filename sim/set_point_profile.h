// Set points as piecewise constant functions of time.

#ifndef SIM_SET_POINT_PROFILE_H_
#define SIM_SET_POINT_PROFILE_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle::sim {

// From `time` on (included), the set point of output `output` is `value`.
struct SetPointStep {
  int output = 0;
  double time = 0.0;
  double value = 0.0;
};

// All set points are 0 before their first step. Steps may come in any order;
// of two at the same time for one output the later in the list holds.
struct SetPointProfile {
  std::vector<SetPointStep> steps;

  absl::Status Validate(int num_outputs) const;
  // p × N: the set points at 0, Δt, …, (N−1) Δt. A step within 1e-9 Δt after a
  // sample counts as on it.
  Eigen::MatrixXd Sample(int num_outputs, double sample_time,
                         int samples) const;
};

}  // namespace mle::sim

#endif  // SIM_SET_POINT_PROFILE_H_
