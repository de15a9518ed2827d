// A discrete state-space model with a correction that was found of the
// transfer functions that describe it:
//
//   y = G u + Σ (ψ_ij − φ_ij) u_j   over the pairs that have changed,
//
// φ the transfer functions before, ψ after. The states of G stay as they are;
// those of the differences stand below them, with a line of delays for each
// input and output whose dead times differ from what G takes out. Pairs that
// have not changed respond as before, to rounding, and what the description
// misses stays.

#ifndef MLE_EXCHANGE_STATE_SPACE_CORRECTION_H_
#define MLE_EXCHANGE_STATE_SPACE_CORRECTION_H_

#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space.h"

namespace mle {

// `system` is valid and has D = 0, `before` and `after` its channels. Without
// a changed element it is `system`. InvalidArgument where an element cannot be
// simulated at its sample time, or where the dead times take more than
// kMostAddedStates states.
inline constexpr int kMostAddedStates = 5000;
absl::StatusOr<DiscreteStateSpace> WithChange(const DiscreteStateSpace& system,
                                              const ProcessModel& before,
                                              const ProcessModel& after);

}  // namespace mle

#endif  // MLE_EXCHANGE_STATE_SPACE_CORRECTION_H_
