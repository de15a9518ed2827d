// What the explanations that won make of the elements: which have aged, and
// which only seem to.

#ifndef MLE_MAINTAIN_AGED_ELEMENTS_H_
#define MLE_MAINTAIN_AGED_ELEMENTS_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/explain/competition.h"
#include "mle/explain/explanation.h"
#include "mle/maintain/candidates.h"

namespace mle {

bool IsClock(ExplanationKind kind);

// Whether a gain that changed during the record is another one at its end, and
// one that a model can hold.
bool Lasts(const Explanation& explanation);

// The element with what won. Fails where it has none that can be simulated.
absl::StatusOr<TransferFunction> ExplainedElement(const Candidates& candidates,
                                                  int output, int input);

// Beyond what clocks are wrong by, all dead times have changed.
double BelievedDelay(const Candidates& candidates, int output, int input);

// An explanation of an input that another output shows. Its clock is not among
// them: that competes for all outputs together (competition.cc).
struct ShownOfInput {
  int output = 0;
  Explanation explanation;
};

// An effect at an input reaches all that it drives: where one output shows it
// and another an aged element instead, one of them is wrong.
std::optional<ShownOfInput> ContestedBy(const Competition& competition,
                                        int output, int input);

// The inputs of the elements that have aged by what won.
std::vector<bool> AgedInputs(const Candidates& candidates, int output);

}  // namespace mle

#endif  // MLE_MAINTAIN_AGED_ELEMENTS_H_
