// Set points as functions of time: steps, ramps and the small moves of an
// optimiser.

#ifndef SIM_SET_POINT_PROFILE_H_
#define SIM_SET_POINT_PROFILE_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "sim/signal_step.h"

namespace mle::sim {

// From `time` on (included), the set point of output `output` is `value`.
struct SetPointStep {
  int output = 0;
  double time = 0.0;
  double value = 0.0;
};

// A change that is added to what the steps say.
struct SetPointMove {
  int output = 0;
  SignalStep change;
};

// All set points are 0 before their first step. Steps may come in any order;
// of two at the same time for one output the later in the list holds.
struct SetPointProfile {
  std::vector<SetPointStep> steps;
  std::vector<SetPointMove> moves = {};

  absl::Status Validate(int num_outputs) const;
  // p × N: the set points at 0, Δt, …, (N−1) Δt. A step within 1e-9 Δt after a
  // sample counts as on it.
  Eigen::MatrixXd Sample(int num_outputs, double sample_time,
                         int samples) const;
};

// The profile whose samples at 0, Δt, … are the columns of `set_points` (p ×
// N).
SetPointProfile ProfileOf(const Eigen::MatrixXd& set_points,
                          double sample_time);

// The moves of an optimiser until `duration`: every `interval` > 0, the first
// after one, the set point goes to another distance from the profile, Gaussian
// with the standard deviation `deviation` ≥ 0.
std::vector<SetPointMove> DrawOptimiserMoves(int output, double interval,
                                             double deviation, double duration,
                                             std::uint64_t seed,
                                             std::uint64_t stream);

}  // namespace mle::sim

#endif  // SIM_SET_POINT_PROFILE_H_
