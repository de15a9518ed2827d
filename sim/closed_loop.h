// A plant under a sampled controller, with measurement noise.
//
// The controller is a callable and nothing else is known of it. At every
// control instant (each Δt_c, the first at t = 0) it is given the measured
// outputs and the set points of that instant, and returns the inputs that act
// from the NEXT control instant on; the inputs of the first period are zero.
//
//   MLE_ASSIGN_OR_RETURN(
//       const Record record,
//       SimulateClosedLoop(
//           plant,
//           [&mpc](const auto& y, const auto& r, auto next_u) {
//             mpc.Step(y, r, next_u);
//           },
//           {.steps = {{.output = 0, .time = 500.0, .value = 1.0}}}, {}));

#ifndef SIM_CLOSED_LOOP_H_
#define SIM_CLOSED_LOOP_H_

#include <cstdint>
#include <functional>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "sim/set_point_profile.h"

namespace mle::sim {

// (measured outputs (p), set points (p), next inputs (m), to be filled in).
using Controller = std::function<void(
    const Eigen::Ref<const Eigen::VectorXd>& measured_outputs,
    const Eigen::Ref<const Eigen::VectorXd>& set_points,
    Eigen::Ref<Eigen::VectorXd> next_inputs)>;

struct ClosedLoopOptions {
  double sample_time = 0.2;       // Δt > 0
  double control_period = 1.0;    // Δt_c, a whole multiple of Δt
  double duration = 1000.0;       // > 0; samples at 0, Δt, … up to duration
  double noise_variance = 0.001;  // σ² ≥ 0 of each output, white at every Δt
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;  // tells the runs of one seed apart

  absl::Status Validate() const;
};

// From rest. The record holds the measured outputs, the inputs and the set
// points at every Δt.
//
// FailedPrecondition, with the channel and the time, if the loop runs away: a
// value is not finite or beyond 1e6 times the size that it may have in this
// experiment. That size is a_i, the larger of an output's greatest set point
// and the noise's standard deviation (1 where all are zero), carried over to
// the other channels by the static gains K:
//
//   input j:  v_j = max_i a_i / |K_ij| over K_ij ≠ 0;
//   output i: max(a_i, max_j |K_ij| v_j),
//
// so that no choice of units raises a false alarm.
absl::StatusOr<Record> SimulateClosedLoop(const ProcessModel& plant,
                                          const Controller& controller,
                                          const SetPointProfile& set_points,
                                          const ClosedLoopOptions& options);

}  // namespace mle::sim

#endif  // SIM_CLOSED_LOOP_H_
