// Changes of a signal at given times, which add up: by `size` from `time` on,
// in the course of `duration` evenly, or at once.

#ifndef SIM_SIGNAL_STEP_H_
#define SIM_SIGNAL_STEP_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle::sim {

struct SignalStep {
  double time = 0.0;
  double size = 0.0;
  double duration = 0.0;  // ≥ 0; 0: at once, the sample at `time` included

  absl::Status Validate() const;
};

// Adds the step to a signal sampled at 0, Δt, …. A time within 1e-9 Δt after a
// sample counts as on it. For a valid step.
void AddStep(const SignalStep& step, double sample_time,
             Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> signal);

}  // namespace mle::sim

#endif  // SIM_SIGNAL_STEP_H_
