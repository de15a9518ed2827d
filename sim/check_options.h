// Checks that the options of the simulations share. The messages name field,
// value and the constraint broken.

#ifndef SIM_CHECK_OPTIONS_H_
#define SIM_CHECK_OPTIONS_H_

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle::sim {

// Finite and > 0.
absl::Status CheckPositive(const char* field, double value);
// Finite and ≥ 0.
absl::Status CheckNotNegative(const char* field, double value);
// In [0, 1].
absl::Status CheckProbability(const char* field, double value);
// Empty, or `size` values that are finite and ≥ 0.
absl::Status CheckNoneOrNotNegative(const char* field,
                                    const Eigen::VectorXd& values, int size);

}  // namespace mle::sim

#endif  // SIM_CHECK_OPTIONS_H_
