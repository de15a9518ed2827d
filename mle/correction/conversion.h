// Conversion of a process model into an ARX model, from a record of its
// response to an excitation (the paper's Eq. 1):
//
//   R = argmin 1/(2N) ‖Y₀ − R X₀‖_F² + λ₀ ‖R‖₁.
//
// The record must carry the measurement noise of the plant the model will be
// corrected on. Without it R becomes a nearly pure autoregression, which
// doubles the noise in its predictions and hides the mismatch (docs/method.md).

#ifndef MLE_CORRECTION_CONVERSION_H_
#define MLE_CORRECTION_CONVERSION_H_

#include "absl/status/statusor.h"
#include "mle/correction/correction_options.h"
#include "mle/data/record.h"

namespace mle {

absl::StatusOr<ConversionSummary> ConvertToArx(
    const Record& excitation, const ConversionOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_CONVERSION_H_
