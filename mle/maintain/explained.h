// The consequences of the competition of explanations for the correction:
// evidence for the decision, and the estimate by instruments where it is taken.

#ifndef MLE_MAINTAIN_EXPLAINED_H_
#define MLE_MAINTAIN_EXPLAINED_H_

#include <optional>
#include <string>

#include "mle/explain/explanation.h"
#include "mle/maintain/candidates.h"
#include "mle/maintain/decision.h"

namespace mle {

// "gain of top ← reflux × 0.71", "the time stamps of top are 2 min late".
std::string DescribeExplanation(const ProcessModel& model, int output,
                                const Explanation& explanation);

// Whether what won for output i misleads a correction of its other elements. A
// reversed sign is a mistake of configuration, which no change of the others
// makes up for. Where a load comes with set points, as this output or another
// shows, set points drive more than the plant.
bool Misleads(const Competition& competition, int i);

// Of blocks held out, with what won: all horizons together, none much worse,
// one by more than chance.
bool PredictsBetter(const OutputExplanation& output);

// Nothing where the output has no judge; there is a competition.
std::optional<InstrumentEvidence> EvidenceByInstruments(
    const Candidates& candidates, int output);

// Puts the gains, time constants and dead times that won in place of what
// `estimate` proposes for this output; changes that are not worth making are
// left out.
void TakeExplained(const Candidates& candidates, int output,
                   Estimate& estimate);

}  // namespace mle

#endif  // MLE_MAINTAIN_EXPLAINED_H_
