// Performance of a loop in a set-point change, from its record alone, relative
// to its design:
//
//   index = J_design / J_achieved,   J = Σ_i Σ_k (y_i(k) − r_i(k))²,
//
// from the change to the end of the window. J_design is that of the controller
// on its own model, plus the measurement noise; a loop as designed has an index
// around 1, one whose plant has aged a smaller one. (The design-case benchmark:
// Patwardhan and Shah, J. Process Control 12, 2002, 475–489.)

#ifndef APPS_LIFECYCLE_PERFORMANCE_H_
#define APPS_LIFECYCLE_PERFORMANCE_H_

#include "absl/status/statusor.h"
#include "control/mpc_options.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle::lifecycle {

// `window` holds one change of set point, at sample `change`.
absl::StatusOr<double> PerformanceIndex(const ProcessModel& model,
                                        const control::MpcOptions& controller,
                                        const Record& window, int change,
                                        double noise_variance);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_PERFORMANCE_H_
