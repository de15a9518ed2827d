// The flags of mle_lifecycle for the loop: sampling, controller, limits, noise
// and disturbances, and how much of it is simulated.

#ifndef APPS_LIFECYCLE_LOOP_FLAGS_H_
#define APPS_LIFECYCLE_LOOP_FLAGS_H_

#include "Eigen/Core"
#include "absl/status/status.h"
#include "apps/lifecycle/operation.h"
#include "mle/model/process_model.h"

namespace mle::lifecycle {

// The sample time and the control period.
absl::Status SetPeriods(OperationOptions& operation);

// All others. Limits that are not given follow from the set points' `range`
// (p): inputs may go to four times what holds the outputs at any corner of it,
// outputs to one and a half times it.
absl::Status SetOperation(const ProcessModel& model,
                          const Eigen::VectorXd& range, double hours_per_unit,
                          OperationOptions& operation);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_LOOP_FLAGS_H_
