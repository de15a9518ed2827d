// The evidence that decision.h decides by, gathered from the candidates.

#ifndef MLE_MAINTAIN_EVIDENCE_H_
#define MLE_MAINTAIN_EVIDENCE_H_

#include "mle/maintain/candidates.h"
#include "mle/maintain/decision.h"

namespace mle {

Evidence GatherEvidence(const Candidates& candidates,
                        const Validation& validation);

}  // namespace mle

#endif  // MLE_MAINTAIN_EVIDENCE_H_
