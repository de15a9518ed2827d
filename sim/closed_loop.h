// A plant under a sampled controller, with measurement noise and other
// conditions (plant_conditions.h).
//
// The controller is a callable. At every
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
#include "sim/plant_conditions.h"
#include "sim/plant_model.h"
#include "sim/set_point_profile.h"

namespace mle::sim {

// (measured outputs (p), set points (p), next inputs (m), to be filled in).
//
// Measured outputs are never NaN: a lost sample is the last good one, 0 before
// the first. On entry the next inputs hold, for inputs with the role of
// disturbances, their values at this instant, measured without error; what the
// controller leaves there is not used. The others are on entry what it asked
// for last.
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

// The record of any plant from its present state on, at every Δt: the outputs
// as measured (NaN where a sample was lost), the inputs as the valves let them
// through (what an actuator or a load makes of them the record does not know),
// and the set points, as the archive exports them. The plant's sample time must
// be that of the options.
//
// `channels` is a process model of the plant's inputs and outputs: it gives
// their names and roles, and with its static gains the size of what is to be
// expected.
//
// FailedPrecondition, with the channel and the time, if the loop diverges: a
// value is not finite or beyond 1e6 times that size (runaway.h), where an
// output's own size is the largest of its set point, its disturbances and the
// noise's standard deviation. InvalidArgument where options do not hold, or
// plant and channels differ in size.
absl::StatusOr<Record> SimulateClosedLoop(
    PlantModel& plant, const ProcessModel& channels,
    const Controller& controller, const SetPointProfile& set_points,
    const ClosedLoopOptions& options, const PlantConditions& conditions = {});

// The same for a transfer matrix from rest, which needs no other `channels`.
absl::StatusOr<Record> SimulateClosedLoop(
    const ProcessModel& plant, const Controller& controller,
    const SetPointProfile& set_points, const ClosedLoopOptions& options,
    const PlantConditions& conditions = {});

}  // namespace mle::sim

#endif  // SIM_CLOSED_LOOP_H_
