// The corrected model from windows of records.
//
// The output-error correction runs for every estimator: its test of no change
// guards them all, and its noise is what the ARX conversion is made under.
// Where the test finds no change the initial model stays, whatever the
// estimator. Only ΔR of complete records around a given
// conversion (EstimationOptions::converter) does without it, if no test or
// another one guards it.
//
//   MLE_ASSIGN_OR_RETURN(const Estimate estimate,
//                        EstimateModel(model, windows, EstimationOptions()));
//
// Hold-out validation (validation.h), the decision (decision.h) and the models
// for use (corrected_model.h) stand upon it; CorrectFromRecords() (correct.h)
// does all of them in turn.

#ifndef MLE_MAINTAIN_ESTIMATION_H_
#define MLE_MAINTAIN_ESTIMATION_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/correction/correction_options.h"
#include "mle/data/record.h"
#include "mle/maintain/message.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

class Correction;   // mle/correction/correction.h
struct SharedFits;  // shared_fits.h

enum class Estimator {
  // Gains, time constants and dead times of the model's elements
  // (output_error_correction.h).
  kOutputError,
  // ΔR of the ARX model by lasso, any shape of response: the paper's method
  // (correction.h).
  kArx,
};

// The test by which a change is proposed at all.
enum class ChangeTest {
  // The likelihood-ratio test of the output-error correction, calibrated on
  // simulated records where χ² leaves doubt (no_change_test.h).
  kCalibrated,
  // The same test by χ² alone.
  kChiSquare,
  // Whether the inputs explain part of the initial model's residuals
  // (model_adequacy.h), without any structure: for kArx alone.
  kAdequacy,
  // Nothing: ΔR, or the fit with every element free, is proposed as it is.
  kNone,
};

// In the order of the enum.
const std::vector<Estimator>& AllEstimators();

// "output_error", "arx".
std::string_view NameOf(Estimator estimator);
// "calibrated", "chi_square", "adequacy", "none".
std::string_view NameOf(ChangeTest test);

// The reverse; InvalidArgument lists the names.
absl::StatusOr<Estimator> ParseEstimator(std::string_view name);
absl::StatusOr<ChangeTest> ParseChangeTest(std::string_view name);

// A λ that corrects nothing, the last of the grid of `correction`.
inline constexpr double kNoCorrectionLambda = 1e6;

// 0, twelve values a decade from 1e-7 to 10, and one that corrects nothing: in
// scaled units (channel_scales.h) every λ that matters lies between.
Eigen::VectorXd DefaultLambdaGrid();

// The test of no change, calibrated on simulated records (no_change_test.h).
struct NullCalibration {
  int replicates = 0;   // simulated; 0 where χ² leaves no doubt
  double factor = 1.0;  // c ≥ 1
  double p_value = 1.0;
};

struct NullCalibrationOptions {
  // ≥ 1; of a plant with more than 12 degrees of freedom fewer, at least 3, so
  // that the mean is of as many degrees.
  int replicates = 12;
  double doubt = 4.0;  // c up to it is thought possible, ≥ 1
  std::uint64_t seed = 1;

  absl::Status Validate() const;
};

// The units in which the ARX correction is set up (channel_scales.h).
struct ChannelScales {
  Eigen::VectorXd outputs;  // p, s_i
  Eigen::VectorXd inputs;   // m, s_j
};

// Of the conversion in those units.
struct ConversionSettings {
  int order = 0;           // d; 0: see ChooseOrder()
  double penalty = 1e-6;   // λ₀ ≥ 0
  int samples = 50000;     // of the excitation
  std::uint64_t seed = 1;  // of the excitation
  LassoSolverOptions solver;

  absl::Status Validate() const;
  // d of this model: `order`, or ChooseOrder().
  int OrderFor(const ProcessModel& model, double sample_time) const;
};

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

// Errors of a model on a record whose inputs are all known: p × samples, NaN
// where there is no measurement or no prediction yet (prediction.h).
using Predictor =
    std::function<Eigen::MatrixXd(const Record& record, int horizon)>;

// The fit to one set of windows.
struct EstimateFit {
  // By the calibrated test; `output_error` says so too.
  bool change_proposed = false;
  NullCalibration test;
  OutputErrorCorrection output_error;
  // For the estimator arx, where a change is proposed; else null.
  std::shared_ptr<const Correction> arx;
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
