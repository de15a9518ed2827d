// The evidence that decision.h decides by, gathered from a result.

#ifndef MLE_MAINTAIN_EVIDENCE_H_
#define MLE_MAINTAIN_EVIDENCE_H_

#include <vector>

#include "mle/explain/competition.h"
#include "mle/maintain/decision.h"
#include "mle/maintain/estimation.h"

namespace mle {

struct CorrectionResult;

// p: outputs of whose residuals the inputs explain a part, for which no shape
// was estimated.
std::vector<bool> UnexplainedOutputs(const Estimate& estimate);

// `result` has everything but the decision; `unexplained` is of the estimate
// before any proposal was taken back; `competition` may be null.
Evidence GatherEvidence(const CorrectionResult& result,
                        const std::vector<bool>& unexplained,
                        const Competition* competition);

}  // namespace mle

#endif  // MLE_MAINTAIN_EVIDENCE_H_
