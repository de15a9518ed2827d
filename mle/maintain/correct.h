// The product: a model and records in, a decision and the corrected model out.
//
//   RecordData → Candidates → Validation → Verdict → CorrectionResult
//
// Records are examined and cut into windows; what may explain them is found
// (an estimate by likelihood, explanations of what set points drive) and judged
// by held-out data; the decision is made, output by output; and the result is
// built: the model for use, diagnostics, certificates.
//
//   MLE_ASSIGN_OR_RETURN(
//       const CorrectionResult result,
//       CorrectFromRecords("column.json", {"march.csv"}, {}, {}));
//   if (result.decision == Decision::kCorrected)
//   use(result.corrected.response);
//
// Nothing is printed: warnings are data (message.h), progress is told to a
// callback that may stop the run.

#ifndef MLE_MAINTAIN_CORRECT_H_
#define MLE_MAINTAIN_CORRECT_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/correction/pair_information.h"
#include "mle/data/record.h"
#include "mle/explain/competition.h"
#include "mle/explain/curves.h"
#include "mle/filter/output_filter.h"
#include "mle/maintain/corrected_model.h"
#include "mle/maintain/decision.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/message.h"
#include "mle/maintain/records.h"
#include "mle/maintain/validation.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle {

struct CorrectOptions {
  RecordOptions records;
  EstimationOptions estimation;
  HoldOutOptions hold_out;
  ExplainOptions explain;
  DecisionOptions decision;
  FilterOptions filter;
  // NΔt of the step responses, ≥ 0 in the model's time unit; 0: the model's
  // settling time, or twice the records. From 5 to 1,000,000 samples.
  double response_horizon = 0.0;
  // Largest relative duality gap of a lasso fit that is used, > 0.
  double accepted_gap = 1e-6;
  // Largest step to the optimum, in standard deviations of the noise, that
  // goes without a warning, > 0 (FitCertificate::gradient).
  double accepted_gradient = 1e-2;
  // Whether the model is handed over as an ARX and as a state-space model too,
  // and whether residuals are examined and pairs assessed.
  bool make_arx = true;
  bool examine = true;
  // Errors of the controller's own predictions, where its model is not the
  // process model given (a step-response or ARX model, say): a correction has
  // to beat these. Empty: those of the process model.
  Predictor in_use;
  // 0: one for each processor. The result does not depend on it.
  int threads = 0;
  ProgressCallback progress;

  // Names the field, its value and the constraint broken.
  absl::Status Validate() const;
};

// How two models differ, by the sum of squares of their step responses.
struct ResponseDistance {
  double total = 0.0;     // E: all pairs and samples
  double relative = 0.0;  // √(E / Σ φ²), φ of the first model
  // p × m: the same for each pair; where the first model has none, relative to
  // the largest of its output.
  Eigen::MatrixXd elements;
};

ResponseDistance CompareResponses(const StepResponse& from,
                                  const StepResponse& to);

struct CorrectionResult {
  ProcessModel initial;
  CorrectOptions options;
  // Records as they were used, bad samples marked, and their windows.
  RecordData data;

  Decision decision = Decision::kNoChange;
  std::vector<Message> reasons;
  std::vector<Acceptance> accepted_outputs;  // p
  // Test of no change, estimates with covariances, noise, certificates; of what
  // was proposed, what is taken.
  Estimate estimate;
  // p: what explains the records, by what set points drive of them; outputs
  // without a judge say why. Empty without CorrectOptions::examine, and where
  // the data forbid a correction.
  std::vector<OutputExplanation> explanations;
  // The information of the windows about each pair, by the model's own values
  // and the noise found.
  PairInformation information;
  // The proposal by gains, time constants and dead times, with their values; it
  // stays here whatever of it is taken.
  OutputErrorFit proposed;
  // Scores of each output at each horizon, where records were held out: of the
  // proposal, unless something else of an output is taken (NaN; `explanations`
  // have errors held out), or nothing of it while others are (as it was).
  Validation validation;
  int max_lag = 0;                                  // of the diagnostics
  std::vector<ResidualReport> initial_residuals;    // p
  std::vector<ResidualReport> corrected_residuals;  // p

  // The model for use: the initial one unless `decision` is kCorrected.
  CorrectedModel corrected;
  // The curves that the records showed, which `initial` has as transforms of
  // its channels beside what was given (empty: none); `corrected` are the
  // elements between them. `data` are in these variables (linearise.h).
  std::vector<FoundCurve> curves;
  std::vector<FopdtElement> fopdt;  // p × m, row by row
  ProcessModel fopdt_model;         // the same as a process model
  // The corrected model by transfer functions: `corrected.process`, or elements
  // of low order nearest to an ARX model.
  ProcessModel model;
  // Of `corrected`, with the disturbances of the outputs where the filter of
  // one is better than that in use; CorrectOptions::make_arx.
  StateSpaceForm state_space;
  // p: the disturbance of each output beside `model`, and its filter. Empty
  // without CorrectOptions::examine and filter.estimate, and where the data
  // forbid a correction.
  std::vector<OutputFilter> filters;
  StepResponse initial_response;
  ResponseDistance change;  // from the initial to the corrected response

  std::vector<Message> notes;     // what was found, of no consequence
  std::vector<Message> warnings;  // what weakens the result
  // Why the result is not usable: fits that failed or are not exact.
  std::vector<Message> failures;

  bool accepted() const { return decision == Decision::kCorrected; }
  bool usable() const { return failures.empty(); }
};

// The change of the gain of an element that these records would have shown, as
// a share: by what set points drive of the output where that judges it, by the
// noise found elsewhere. Infinite where nothing tells of it.
double DetectableGain(const CorrectionResult& result, int output, int input);

// "The gain of steam follows its position: × 0.62 at 20 %, × 1.7 at 80 %".
std::string DescribeCurve(const ProcessModel& model, const FoundCurve& curve);

// That the model is right: of the test of no change or, where this finds none,
// of the explanation that set points leave least doubt of (one of all outputs,
// by Bonferroni).
double PValue(const CorrectionResult& result);

// Whether the corrected element has another order, or other zeros, than the
// model's: another shape, or a new path. Of ΔR, which has no elements, it is
// not said.
bool HasOtherShape(const CorrectionResult& result, int output, int input);

// From records in memory, sampled alike, whole and in order of time.
// InvalidArgument for options, models and records that are wrong,
// FailedPrecondition where a fit behind the model for use is not what it
// should be, Cancelled by the callback.
absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const ProcessModel& model, std::vector<Record> records,
    const CorrectOptions& options);

// From files: a model (model_file.h) and exports of a historian (CSV),
// imported as `import` says.
absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const std::string& model_path, const std::vector<std::string>& record_paths,
    const HistorianOptions& import, const CorrectOptions& options);

// From what LoadRecords() or PrepareRecords() (records.h) made with
// `options.records`: for callers that look at the data before they go on.
absl::StatusOr<CorrectionResult> CorrectFromData(const ProcessModel& model,
                                                 RecordData data,
                                                 const CorrectOptions& options);

}  // namespace mle

#endif  // MLE_MAINTAIN_CORRECT_H_
