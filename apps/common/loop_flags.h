// Flags of a closed loop under predictive control, the same in every command
// that simulates one.
//
//   MLE_ASSIGN_OR_RETURN(control::MpcOptions controller,
//                        ControllerFromFlags(model));

#ifndef APPS_COMMON_LOOP_FLAGS_H_
#define APPS_COMMON_LOOP_FLAGS_H_

#include "absl/status/statusor.h"
#include "control/mpc.h"
#include "gflags/gflags_declare.h"
#include "mle/model/process_model.h"

DECLARE_double(sample_time);     // Δt
DECLARE_double(control_period);  // Δt_c
DECLARE_double(noise_variance);  // σ²

namespace mle {

// Control period, horizons, weights and observer; without limits. Only what is
// said about a flag's form is checked: InvalidArgument names the flag.
absl::StatusOr<control::MpcOptions> ControllerFromFlags(
    const ProcessModel& model);

}  // namespace mle

#endif  // APPS_COMMON_LOOP_FLAGS_H_
