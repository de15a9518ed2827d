// The result of a correction: the model for use in its forms, and what is told
// of it. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_BUILT_RESULT_H_
#define MLE_MAINTAIN_BUILT_RESULT_H_

#include "absl/status/statusor.h"
#include "mle/maintain/candidates.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/decision.h"
#include "mle/maintain/validation.h"

namespace mle {

// What the verdict takes of the candidates, made into models, its residuals
// examined.
absl::StatusOr<CorrectionResult> BuildResult(Candidates candidates,
                                             Validation validation,
                                             Verdict verdict);

}  // namespace mle

#endif  // MLE_MAINTAIN_BUILT_RESULT_H_
