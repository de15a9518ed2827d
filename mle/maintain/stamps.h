// What time stamps and averages of an output's samples may look like: longer or
// shorter dead times, and a little of everything.

#ifndef MLE_MAINTAIN_STAMPS_H_
#define MLE_MAINTAIN_STAMPS_H_

#include "mle/maintain/candidates.h"

namespace mle {

// The largest change of its dead times that the clock of an output may have
// made, in the model's time unit: DecisionOptions::clock_error, five samples,
// or the time in which the output is measured once, if nothing is declared of
// its sampling. Where a time unit is samples, seconds say nothing.
double MostOfClock(const Candidates& candidates, int output);

// The relative change of an element's step response that is not worth making:
// DecisionOptions::least_change, or what the declared average does to it.
double LeastChange(const Candidates& candidates, int output, int input);

}  // namespace mle

#endif  // MLE_MAINTAIN_STAMPS_H_
