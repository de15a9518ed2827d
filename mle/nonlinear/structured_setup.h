// Checks the arguments of a structured correction and sets up its outputs.
// Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_STRUCTURED_SETUP_H_
#define MLE_NONLINEAR_STRUCTURED_SETUP_H_

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle {

struct OutputSetup {
  std::unique_ptr<OutputErrorProblem> problem;
  OutputPoint start;  // the model's values
  OutputFitBounds bounds;
  // m: the element is present, its input moves, and `samples` is OK.
  std::vector<bool> informed;
  absl::Status samples;  // whether they are enough for the elements
};

// One for each output; errors as of CorrectStructure(). Too few samples are an
// error where no output has enough.
absl::StatusOr<std::vector<OutputSetup>> SetUpOutputs(
    const ProcessModel& model, const std::vector<Record>& records,
    const StructuredOptions& options);

// The longest of dead time + `time_scales` time scales of an element, in
// samples, but no more than this share of the shortest record; ≥ 1.
int LongestLag(const std::vector<OutputSetup>& setups,
               const std::vector<Record>& records, double time_scales,
               double share);

}  // namespace mle

#endif  // MLE_NONLINEAR_STRUCTURED_SETUP_H_
