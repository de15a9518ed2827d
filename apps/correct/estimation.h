// The corrected model from windows of records.
//
// The structured correction always runs: its test of no change guards every
// estimator, and its noise is what the ARX conversion is made under. Where it
// finds no change the initial model stays, whatever the estimator.
//
//   structured  gains, time constants and dead times (the default)
//   arx         ΔR by lasso, any shape of response (the paper's method)
//   combined    structured, and ΔR for the outputs in which that leaves
//               something the inputs explain (combined.h)

#ifndef APPS_CORRECT_ESTIMATION_H_
#define APPS_CORRECT_ESTIMATION_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "apps/correct/conversion_scales.h"
#include "apps/correct/null_calibration.h"
#include "apps/correct/prediction.h"
#include "mle/correction/combined.h"
#include "mle/correction/correction.h"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle::correct {

enum class Estimator { kStructured, kArx, kCombined };

std::string_view NameOf(Estimator estimator);

// A λ that corrects nothing, the last of the grid of `correction`.
inline constexpr double kNoCorrectionLambda = 1e6;

// 0, twelve values a decade from 1e-7 to 10, and one that corrects nothing: in
// scaled units (conversion_scales.h) every λ that matters lies between.
Eigen::VectorXd DefaultLambdaGrid();

struct EstimationOptions {
  Estimator estimator = Estimator::kStructured;
  // ΔR at λ*, which is chosen on the exact path, solved as a smooth problem by
  // Ceres. With structured.robust_loss it is solved with that loss, by Ceres.
  bool solve_by_ceres = false;
  StructuredOptions structured;
  NullCalibrationOptions calibration;
  ConversionSettings conversion;
  CorrectionOptions correction;
};

// What was fitted to one set of windows.
struct Fit {
  // By the calibrated test; `structured` says so too.
  bool change_proposed = false;
  NullCalibration test;
  StructuredCorrection structured;
  // The test whether structure is enough, of the estimator combined.
  std::optional<ModelAdequacy> adequacy;
  // ΔR: of the estimator arx where a change is proposed, of combined where
  // structure is not enough.
  std::optional<Correction> arx;
  // R + ΔR at its λ*, scaled, and the relative duality gap.
  ArxModel arx_model;
  double arx_gap = 0.0;
  // Predictions of the initial and of the corrected model; equal without a
  // proposal.
  Predictor initial;
  Predictor corrected;
};

// What an estimator needs besides windows, made once.
struct Setting {
  ProcessModel initial;
  EstimationOptions options;
  // Of the full fit to all windows.
  std::vector<NoiseEstimate> noise;
  // The full fit, which stands in for outputs that are missing.
  ProcessModel filler;
  ChannelScales scales;
  // R around which ΔR is sought, in scaled units: of the initial model for arx;
  // of combined, where structure is not enough, of the structured model but for
  // the outputs that ΔR is for.
  std::optional<ConversionSummary> conversion;
  // p: outputs that R + ΔR is for.
  std::vector<bool> arx_outputs;
};

// Everything from all windows.
struct Estimate {
  Setting setting;
  Fit fit;
};

absl::StatusOr<Estimate> EstimateModel(const ProcessModel& initial,
                                       const std::vector<Record>& windows,
                                       const EstimationOptions& options);

// The two models that a fit to `windows` leaves to compare, where `full` is the
// fit to all windows and proposes a change. The structured estimator fits the
// elements that have aged according to `full`, all others at their initial
// values: a part of the records would not always name the same ones. arx keeps
// λ. Noise and conversion are those of `setting`.
absl::StatusOr<Predictor> PredictFromPart(const Setting& setting,
                                          const Fit& full,
                                          const std::vector<Record>& windows);

// What comes out for use.
struct CorrectedModel {
  // Where no output is ΔR's: the process model with the initial one's
  // shapes.
  std::optional<ProcessModel> process;
  ArxModel arx;           // in the units of the records
  StepResponse response;  // at 0, Δt, … (response_samples)
  // Standard errors of `response`; where there is a process model.
  std::optional<StepResponse> errors;
  double max_relative_gap = 0.0;  // of all lasso fits
};

// The initial model where `accepted` is false.
absl::StatusOr<CorrectedModel> MakeCorrectedModel(const Estimate& estimate,
                                                  bool accepted,
                                                  double sample_time,
                                                  int response_samples);

}  // namespace mle::correct

#endif  // APPS_CORRECT_ESTIMATION_H_
