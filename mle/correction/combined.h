// Structured correction, and a correction ΔR of the ARX model converted from it
// for the outputs whose residuals still depend on the inputs:
//
//   1. CorrectStructure(): gains, time scales and dead times, with its own test
//      of no change (structured_correction.h).
//   2. TestAdequacy() of the corrected model: whether its structure is right
//      (model_adequacy.h).
//   3. If not, R of that model and CorrectModel() around it, λ by its rule.
//
// Where the plant has the model's structure, step 3 is reached only by false
// alarms, and the result is the structured correction; where an element has
// another order, or an element that was zero is no longer zero, ΔR corrects the
// rest.
//
//   MLE_ASSIGN_OR_RETURN(
//       const CombinedCorrection correction,
//       CompleteStructured(model, structured, windows, convert, options));
//   correction.ComputeStepResponse(0.2, 501);
//
// The conversion needs a record of the excited model, which only a simulation
// has: the caller brings it as a function.

#ifndef MLE_CORRECTION_COMBINED_H_
#define MLE_CORRECTION_COMBINED_H_

#include <functional>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/correction/conversion.h"
#include "mle/correction/correction.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "mle/nonlinear/model_adequacy.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle {

using ArxConverter =
    std::function<absl::StatusOr<ConversionSummary>(const ProcessModel& model)>;

struct CombinedOptions {
  StructuredOptions structured;
  // Probability, in (0, 1), that ΔR is corrected where the structure is right.
  double false_alarm_probability = 0.01;
  CorrectionOptions correction;  // of ΔR

  absl::Status Validate() const;
};

// p: the outputs that the test finds wrong, by Bonferroni's share of the
// false-alarm probability for each of them, and the most suspicious one. None
// where the model is adequate.
std::vector<bool> WrongOutputs(const ModelAdequacy& adequacy,
                               double false_alarm_probability);

struct CombinedCorrection {
  StructuredCorrection structured;
  ModelAdequacy adequacy;  // of structured.corrected.model
  // Where that is not adequate: R, ΔR around it, and the outputs (p) that ΔR is
  // for.
  std::optional<ConversionSummary> conversion;
  std::optional<Correction> correction;
  std::vector<bool> outputs_corrected;

  // Whether anything is changed at all.
  bool change_proposed() const {
    return structured.change_proposed || correction.has_value();
  }
  // Of Model() in the outputs that ΔR is for (`sample_time` must be its own),
  // of the structured model in the others.
  StepResponse ComputeStepResponse(double sample_time, int samples) const;
};

// Steps 2 and 3 for what CorrectStructure() made of the same windows. Errors
// are those of TestAdequacy(), the conversion and CorrectModel().
absl::StatusOr<CombinedCorrection> CompleteStructured(
    const ProcessModel& initial, StructuredCorrection structured,
    const std::vector<Record>& windows, const ArxConverter& convert,
    const CombinedOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_COMBINED_H_
