// What time stamps and averages of an output's samples may look like: longer or
// shorter dead times, and a little of everything.

#ifndef MLE_MAINTAIN_STAMPS_H_
#define MLE_MAINTAIN_STAMPS_H_

#include <optional>

#include "mle/maintain/correct.h"
#include "mle/maintain/message.h"

namespace mle {

// The largest change of its dead times that the clock of an output may have
// made, in the model's time unit: DecisionOptions::clock_error, five samples,
// or the time in which the output is measured once, if nothing is declared of
// its sampling. Where a time unit is samples, seconds say nothing.
double MostOfClock(const CorrectionResult& result, int output);

// The relative change of an element's step response that is not worth making:
// DecisionOptions::least_change, or what the declared average does to it.
double LeastChange(const CorrectionResult& result, int output, int input);

// Whether the output's samples are declared to be means, which no model of
// responses explains to the last.
bool IsAveraged(const CorrectionResult& result, int output);

// Whether one of its dead times may seem longer by so much since its samples
// are averages, or are stamped so: by less than a sample, if nothing is
// declared.
bool MayBeStamps(const CorrectionResult& result, int output, double late);

// A message where stamps that are wrong by no more than the time in which an
// output is measured once do what the proposal for it does: it makes all dead
// times longer, or shorter, alike, or leaves no less than the controller's
// model with its samples shifted.
std::optional<Message> ExplainedByStamps(const CorrectionResult& result,
                                         int output);

}  // namespace mle

#endif  // MLE_MAINTAIN_STAMPS_H_
