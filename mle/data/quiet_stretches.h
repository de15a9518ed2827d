// How long a plant takes to settle after a change.

#ifndef MLE_DATA_QUIET_STRETCHES_H_
#define MLE_DATA_QUIET_STRETCHES_H_

#include "mle/model/process_model.h"

namespace mle {

// Dead time plus five times the slowest time constant of the slowest element:
// what is left of a step's response then is 0.7 % of it.
double SettlingTime(const ProcessModel& model);

}  // namespace mle

#endif  // MLE_DATA_QUIET_STRETCHES_H_
