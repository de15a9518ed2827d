// The fits of all outputs of a plant, side by side. Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_OUTPUT_FITS_H_
#define MLE_NONLINEAR_OUTPUT_FITS_H_

#include <functional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

// fit(0), …, fit(count − 1) on options.threads, until options.after_fit says
// no: then Cancelled.
absl::Status FitEach(int count, const OutputErrorOptions& options,
                     const std::function<void(int)>& fit);

// Every element free that may change, with the lines and steps that are found
// left in the problems.
absl::StatusOr<std::vector<OutputFit>> FitOutputs(
    const std::vector<OutputSetup>& setups, const OutputErrorOptions& options);

// `fit` continued with the elements that are `free` alone, the others at their
// initial values.
OutputFit FitAged(const OutputSetup& setup, const OutputFit& fit,
                  const std::vector<bool>& free,
                  const OutputErrorOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_FITS_H_
