// The certificates of the fits behind a result, and warnings about them.

#ifndef MLE_MAINTAIN_CERTIFICATES_H_
#define MLE_MAINTAIN_CERTIFICATES_H_

#include "absl/status/status.h"
#include "mle/model/step_response.h"

namespace mle {

struct CorrectionResult;

// FailedPrecondition where the corrected model is unstable.
absl::Status CheckResponse(const StepResponse& response);

// Adds warnings and failures of the fits and of the first-order elements with
// dead time to `result`.
void CheckCertificates(CorrectionResult& result);

}  // namespace mle

#endif  // MLE_MAINTAIN_CERTIFICATES_H_
