// The corrected model from windows of records.
//
// The output-error correction runs for every estimator: its test of no change
// guards them all, and its noise is what the ARX conversion is made under.
// Where the test finds no change the initial model stays, whatever the
// estimator (estimator.h). Only ΔR of complete records around a given
// conversion (EstimationOptions::converter) does without it, if no test or
// another one guards it.
//
//   MLE_ASSIGN_OR_RETURN(const Estimate estimate,
//                        EstimateModel(model, windows, EstimationOptions()));
//
// Hold-out validation (hold_out.h), the decision (decision.h) and the models
// for use (corrected_model.h) stand upon it; CorrectFromRecords() (correct.h)
// does all of them in turn.

#ifndef MLE_MAINTAIN_ESTIMATION_H_
#define MLE_MAINTAIN_ESTIMATION_H_

#include <optional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/correction/conversion.h"
#include "mle/correction/correction.h"
#include "mle/data/record.h"
#include "mle/maintain/channel_scales.h"
#include "mle/maintain/estimator.h"
#include "mle/maintain/no_change_test.h"
#include "mle/maintain/prediction.h"
#include "mle/maintain/progress.h"
#include "mle/maintain/shared_fits.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// A λ that corrects nothing, the last of the grid of `correction`.
inline constexpr double kNoCorrectionLambda = 1e6;

// 0, twelve values a decade from 1e-7 to 10, and one that corrects nothing: in
// scaled units (channel_scales.h) every λ that matters lies between.
Eigen::VectorXd DefaultLambdaGrid();

struct EstimationOptions {
  Estimator estimator = Estimator::kOutputError;
  ChangeTest change_test = ChangeTest::kCalibrated;
  // ΔR at λ*, which is chosen on the exact path, solved as a smooth problem by
  // Ceres. With output_error.robust_loss it is solved with that loss, by Ceres.
  bool solve_by_ceres = false;
  OutputErrorOptions output_error;
  NullCalibrationOptions calibration;
  ConversionSettings conversion;
  // R of a model in the units of the records, in place of the conversion that
  // `conversion` describes, for experiments in which the noise is known. The
  // records are then neither scaled nor centred, and λ is in their units: the
  // paper's setting. Empty: ConvertUnderNoise().
  ArxConverter converter;
  CorrectionOptions correction = {.lambdas = DefaultLambdaGrid()};

  // Names the field, its value and the constraint broken.
  absl::Status Validate() const;
};

// The fit to one set of windows.
struct EstimateFit {
  // By the calibrated test; `output_error` says so too.
  bool change_proposed = false;
  NullCalibration test;
  OutputErrorCorrection output_error;
  // For the estimator arx, where a change is proposed.
  std::optional<Correction> arx;
  // R + ΔR at its λ*, scaled, and the relative duality gap.
  ArxModel arx_model;
  double arx_gap = 0.0;
  // Processor time of this thread, fits shared with other estimates included,
  // the conversion of the initial model not.
  double seconds = 0.0;
  // Predictions of the initial model and of the corrected one, each with the
  // noise that it finds in these windows; equal without a proposal. The initial
  // model predicts as it is, not as R.
  Predictor initial;
  Predictor corrected;
};

// The setting of an estimator besides windows, made once.
struct EstimateSetting {
  ProcessModel initial;
  EstimationOptions options;
  // The noise of the full fit to all windows.
  std::vector<NoiseEstimate> noise;
  // The full fit, which stands in for outputs that are missing.
  ProcessModel filler;
  ChannelScales scales;
  // For the estimator arx: R around which ΔR is sought, in scaled units.
  std::optional<ConversionSummary> conversion;
  // p: outputs that R + ΔR is for.
  std::vector<bool> arx_outputs;
};

// Everything from all windows.
struct Estimate {
  EstimateSetting setting;
  EstimateFit fit;
};

// InvalidArgument as of CorrectByOutputError(), Cancelled by `progress`. What
// `shared` (shared_fits.h) already has is not made again.
absl::StatusOr<Estimate> EstimateModel(const ProcessModel& initial,
                                       const std::vector<Record>& windows,
                                       const EstimationOptions& options,
                                       const ProgressCallback& progress = {},
                                       SharedFits* shared = nullptr);

// R of a model in units of these scales, by the converter or under the noise of
// `setting`.
absl::StatusOr<ConversionSummary> ConvertModel(const EstimateSetting& setting,
                                               const ProcessModel& model,
                                               const ChannelScales& scales,
                                               double sample_time);

// Whether anything is proposed for an output, for any, and by ΔR.
bool ProposesChange(const Estimate& estimate, int output);
bool ProposesAny(const Estimate& estimate);
bool ProposesByArx(const Estimate& estimate, int output);
// Whether one is for an element.
bool ProposesElement(const Estimate& estimate, int output, int input);

// Takes the proposal for an output back, or that for an element.
void KeepInitialOutput(int output, Estimate& estimate);
void KeepInitialElement(int output, int input, Estimate& estimate);

// Makes the predictors again, after a proposal was taken back.
absl::Status MakePredictors(const std::vector<Record>& windows,
                            Estimate& estimate);

}  // namespace mle

#endif  // MLE_MAINTAIN_ESTIMATION_H_
