// States that no input reaches, as those of the disturbance models that
// predictive controllers add: from rest they stay 0, and responses from inputs
// to outputs do not know them, whatever their modes are. Internal to this
// project: not installed.

#ifndef MLE_MODEL_UNREACHED_STATES_H_
#define MLE_MODEL_UNREACHED_STATES_H_

#include "mle/model/state_space.h"

namespace mle {

// Leaves these out of `system`, whose matrices fit each other, and returns how
// many there were; one state is left at least. States that zeros of A and B
// separate from every input are left out as they are; where that leaves a
// system that is not valid, and a subspace is left that no input reaches, the
// others are turned into a basis of the one that inputs reach.
int LeaveOutUnreachedStates(DiscreteStateSpace& system);

}  // namespace mle

#endif  // MLE_MODEL_UNREACHED_STATES_H_
