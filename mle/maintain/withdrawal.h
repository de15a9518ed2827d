// Proposals that are taken back before anything is decided. Internal to
// mle/maintain.

#ifndef MLE_MAINTAIN_WITHDRAWAL_H_
#define MLE_MAINTAIN_WITHDRAWAL_H_

#include "absl/status/status.h"
#include "mle/maintain/correct.h"

namespace mle {

// Takes back, by the step responses over `samples`, proposals that change no
// element's response by more than decision.least_change: one by one where they
// are parametric, output by output where they are ΔR's; an absent pair counts
// by the largest response of its output.
absl::Status WithdrawProposals(int samples, CorrectionResult& result);

}  // namespace mle

#endif  // MLE_MAINTAIN_WITHDRAWAL_H_
