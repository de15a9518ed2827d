// Checks the arguments of an output-error correction and sets up its outputs.
// Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_OUTPUT_ERROR_SETUP_H_
#define MLE_NONLINEAR_OUTPUT_ERROR_SETUP_H_

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

struct OutputSetup {
  std::unique_ptr<OutputErrorProblem> problem;
  OutputPoint start;  // the model's values
  OutputFitBounds bounds;
  // m: the element is present, its input moves, and `samples` is OK.
  std::vector<bool> informed;
  absl::Status samples;  // whether they are enough for the elements
};

// One for each output; errors as of CorrectByOutputError(). Too few samples are
// an error where no output has enough.
absl::StatusOr<std::vector<OutputSetup>> SetUpOutputs(
    const ProcessModel& model, const std::vector<Record>& records,
    const OutputErrorOptions& options);

// The longest of dead time + `time_scales` time scales of an element, in
// samples, but no more than this share of the shortest record; ≥ 1.
int LongestLag(const std::vector<OutputSetup>& setups,
               const std::vector<Record>& records, double time_scales,
               double share);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_ERROR_SETUP_H_
