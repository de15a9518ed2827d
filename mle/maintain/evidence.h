// The evidence that decision.h decides by, gathered from a result.

#ifndef MLE_MAINTAIN_EVIDENCE_H_
#define MLE_MAINTAIN_EVIDENCE_H_

#include <vector>

#include "mle/explain/competition.h"
#include "mle/maintain/decision.h"
#include "mle/maintain/estimation.h"

namespace mle {

struct CorrectionResult;

// `result` has everything but the decision; `competition` may be null.
Evidence GatherEvidence(const CorrectionResult& result,
                        const Competition* competition);

}  // namespace mle

#endif  // MLE_MAINTAIN_EVIDENCE_H_
