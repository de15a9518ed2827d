// Correction of the physical parameters of a process model from raw closed-loop
// records. Every element K e^{−Ls} g₀(Ts) of the model keeps its shape (first
// order: 1/(Ts + 1)); its gain K, time scale T and dead time L are fitted by
// maximum likelihood to
//
//   y_i = offset + Σ_j K_ij x_ij(u_j; T_ij, L_ij) + free response + noise,
//
// output by output, where the noise is white (variance r) plus a random walk
// (increment variance q per sample, the drift of the plant), q/r estimated from
// the records, with one offset for each window. Of an integrating element,
// K e^{−Ls} g₀(Ts)/s, K is a slope and x the response to what the inputs differ
// from their first values; its output has one ramp for each window besides, of
// what these values do not balance. Given the past outputs the
// inputs carry no information of their own about the noise, so that this is the
// likelihood of closed-loop records too, whatever the controller.
//
// Then two questions are answered with a stated probability of a false alarm:
// has anything changed (χ² of the fit against the initial model), and which
// elements have (an L1 penalty on each element's change in units of its own
// uncertainty, then a likelihood ratio). Elements that have not keep their
// initial values, and the others are fitted once more.
//
//   MLE_ASSIGN_OR_RETURN(
//       const OutputErrorCorrection correction,
//       CorrectByOutputError(model, windows, OutputErrorOptions()));
//   if (correction.change_proposed) use(correction.corrected.model);
//
// docs/output_error.md has the equations, the decisions and measured figures.

#ifndef MLE_NONLINEAR_OUTPUT_ERROR_CORRECTION_H_
#define MLE_NONLINEAR_OUTPUT_ERROR_CORRECTION_H_

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "mle/nonlinear/robust_loss.h"

namespace mle {

// Records that are deviations from the model's operating point and free of
// drift determine gains two to three times as well without an offset for each
// window.
enum class WindowOffsets {
  // The estimates with offsets and drift, and with neither, averaged by their
  // Akaike weights, all outputs together (Buckland, Burnham and Augustin,
  // Biometrics 53, 1997).
  kAveraged,
  kAlways,
  kNever,  // Neither offsets nor drift.
};

struct OutputErrorCorrection;

// A probability of a false alarm that counts as none: no change is proposed.
inline constexpr double kNoFalseAlarm = 1e-300;

// An element that has aged with a smaller p by all records, and by a part of
// them, is not tested again.
inline constexpr double kBeyondDoubt = 1e-12;

struct OutputErrorOptions {
  // T stays within this factor of its initial value, > 1.
  double max_time_scale_factor = 10.0;
  // L stays within [0, this], ≥ every initial dead time, in the time unit of
  // the model. Infinite: twice the initial dead time plus the initial time
  // scale, but no more than a quarter of the shortest record. The first samples
  // of each window, as long as the largest bound in a row of the model, are
  // not fitted: in them the effect of earlier inputs decays.
  double max_delay = std::numeric_limits<double>::infinity();
  // Whether the noise may have a random walk in it; if not, it is white.
  bool estimate_drift = true;
  // The test of no change has the same weights. Outputs of which an element
  // integrates always have an offset for each window and drift.
  WindowOffsets offsets = WindowOffsets::kAveraged;
  // Loss of the residuals, for records with outliers. The noise variance, the
  // intervals and the tests then hold in its first order.
  RobustLoss robust_loss = RobustLoss::kNone;
  // Probability of a false alarm, in (0, 1), of the test of no change, and of
  // naming any element that has not changed.
  double false_alarm_probability = 0.01;
  // That something has changed is known: the test of no change is made, but
  // does not decide.
  bool change_given = false;
  // p: the outputs that may have changed; the others keep the model, and only
  // their noise is estimated. Empty: all.
  std::vector<bool> outputs = {};
  // Confidence of the intervals, in (0, 1).
  double confidence = 0.95;
  // Most iterations of each Ceres solve, ≥ 1.
  int max_iterations = 100;
  // Records of the same plant in which nothing is asked of it, sampled alike,
  // or none: correlation that the noise shape leaves is looked for in them, too
  // (serial_correlation.h). Nothing is fitted to them.
  std::shared_ptr<const std::vector<Record>> at_rest = nullptr;
  // A correction of the same model by records of which these are a part, or
  // null. Fits then begin at the values and the noise of its `full`, and no
  // AR component, line or step is sought besides those that it has; the change
  // is given, and not tested, nor are elements that have aged in it, and by
  // Wald's test in the part, with p < kBeyondDoubt.
  std::shared_ptr<const OutputErrorCorrection> start = nullptr;
  // Outputs are independent; 0: one thread for each processor.
  int threads = 1;
  // Called after each fit of an output, of all elements and of those that have
  // aged, from any thread, one call at a time; false: no more are begun, and
  // the answer is Cancelled. May be empty.
  std::function<bool()> after_fit = {};

  absl::Status Validate() const;
};

// A periodic disturbance: a sine of one frequency, whose amplitude and phase
// each window has for itself.
struct PeriodicLine {
  double period = 0.0;     // in the time unit of the model
  double amplitude = 0.0;  // root mean square over the windows
};

// A step of an output's level that nothing measured explains, at once or, as of
// a load at an input, behind a lag.
struct LevelStep {
  int record = 0;     // its number
  double time = 0.0;  // of its first sample, as of the record
  double lag = 0.0;   // time constant, in the time unit of the model; 0: none
  double size = 0.0;  // at its end

  // At a time; size (1 − exp(−(when − time + Δt)/lag)) from `time` on.
  double At(double when, double sample_time) const;
};

// White noise plus a random walk and, where the records show one, a coloured
// component a of first or second order with shocks η, Var η = s a sample:
//
//   (1 − φB) a = η   or   (1 − p₁B)(1 − p₂B) a = η,
//   p = exp(−ω (ζ ± √(ζ² − 1))),   ω = −ln φ.
//
// ζ ≥ 1: coloured noise of first order behind a lag, as of a load at an input;
// ζ < 1: a resonance.
struct NoiseEstimate {
  double variance = 0.0;  // r, of the white part
  double ratio = 0.0;     // q/r
  // Each window has an offset of its own. If not, records are deviations from
  // the model's operating point, and free of drift.
  bool offset = true;
  double ar_ratio = 0.0;    // s/r; 0: no coloured component
  double ar_pole = 0.0;     // φ, of one sample
  double ar_damping = 0.0;  // ζ; 0: of first order
  // Standard deviations of ln(q/r), ln(s/r), ln(1/ω) and ln ζ; 0 of what is 0
  // or given.
  std::array<double, 4> log_deviations = {};
  std::vector<PeriodicLine> lines = {};  // beside it
  // By how much correlation that is left raises the likelihood ratio without a
  // change, ≥ 1, and the samples at rest that it was seen in besides.
  double inflation = 1.0;
  int samples_at_rest = 0;
  std::vector<LevelStep> steps = {};
  // Of random errors of the stamps of what is measured now and then, in the
  // model's unit of time; 0: none seen.
  double stamp_deviation = 0.0;

  double increment_variance() const { return ratio * variance; }  // q
  double ar_variance() const;  // of the coloured component, stationary
  double ar_memory() const;    // 1/ω, in samples; 0 without an AR component
};

enum class FitTermination { kNotRun, kConverged, kIterationLimit, kFailed };

// The certificate of the fit of an output.
struct FitCertificate {
  FitTermination termination = FitTermination::kNotRun;
  std::string message;  // of Ceres
  // Largest derivative of the objective by a parameter, as the step to its
  // minimum in standard deviations of the noise; parameters at a bound or in a
  // kink from which the objective rises on both sides do not count.
  double gradient = std::numeric_limits<double>::infinity();
  // Condition of the Jacobian, its columns scaled to one.
  double condition = std::numeric_limits<double>::infinity();
  int rank = 0;
  int num_parameters = 0;
  int iterations = 0;     // of Ceres, all solves together
  int grid_searches = 0;  // for the dead times; the last found nothing better
  bool search_confirmed = false;
  bool at_bound = false;  // a parameter lies at its bound
  // For a robust loss: by how much a sample's weight differs at most from the
  // one it had in the fit. `gradient` is the loss's own.
  double weight_change = 0.0;
};

struct ParameterEstimate {
  double initial = 0.0;
  double value = 0.0;
  // 0 and an interval of one point where the parameter is not fitted.
  double standard_error = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};

enum class ElementState {
  kAbsent,       // zero in the model, and stays so
  kNotInformed,  // its input or output does not move: initial values
  kHeld,         // held at its initial values
  kFitted,
};

struct ElementEstimate {
  ElementState state = ElementState::kAbsent;
  ParameterEstimate gain;
  // The time constant of a first-order element; zeros where there is no lag.
  ParameterEstimate time_scale;
  ParameterEstimate delay;
  // The change of the gain that the test of no change finds nine times of ten,
  // by what the records say of offsets and drift; infinite if not fitted.
  double detectable_gain = std::numeric_limits<double>::infinity();

  // K, T and L as estimated; T is 1 where there is no lag.
  ElementValues values() const;
};

// All elements of one model, fitted or held.
struct OutputErrorFit {
  ProcessModel model;
  std::vector<ElementEstimate> elements;  // row by row: p × m
  // Each output's 3m × 3m covariance of (K, T, L) of its elements in turn.
  std::vector<Eigen::MatrixXd> covariances;
  std::vector<NoiseEstimate> noise;          // p
  std::vector<FitCertificate> certificates;  // p
  // The weight of offsets and drift in the average; noise, certificates and
  // deviances are those of its heavier part.
  double offset_weight = 1.0;
  // p: samples whose weight in a robust loss is below 0.5.
  std::vector<int> down_weighted_samples;
  std::vector<double> deviances;  // p: −2 ln likelihood + const

  const ElementEstimate& element(int output, int input) const {
    return elements[output * model.num_inputs() + input];
  }
  // Standard errors of the step responses at 0, Δt, … (delta method): a band
  // about the model's responses is ± 1.96 of it.
  StepResponse StepResponseErrors(double sample_time, int samples) const;
  // E(M, M̂) to be expected if the covariances are right: Σ of their squares.
  double ExpectedSquaredDistance(double sample_time, int samples) const;
};

struct OutputErrorCorrection {
  // Every element free that the records inform about.
  OutputErrorFit full;
  // The proposal: the elements that have aged free, all others at their initial
  // values; the initial model where no change is proposed.
  OutputErrorFit corrected;

  // The test of no change.
  bool change_proposed = false;
  double p_value = 1.0;
  double statistic = 0.0;      // of the fit against the initial model
  int degrees_of_freedom = 0;  // of its χ² distribution
  // p × m: of each element against its initial values, by Wald's F test in
  // `full`, or by likelihood where that p is larger or the element was found by
  // it; 1 where it is not fitted.
  Eigen::MatrixXd element_p_values;
  // p × m: whether the element has aged.
  Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic> aged;

  std::string FullReport() const;  // Lines for each output and element.
};

// InvalidArgument if an option, the model or a record is invalid, values are
// too large to be squared (beyond 1e60), an element cannot be fitted
// (feedthrough), the records do not match the model or each other, the bounds
// exclude the start, or the samples are too few for the parameters; the message
// names output and element.
absl::StatusOr<OutputErrorCorrection> CorrectByOutputError(
    const ProcessModel& initial, const std::vector<Record>& records,
    const OutputErrorOptions& options);

// `full` of CorrectByOutputError() without its averages over offsets and drift,
// for callers that ask for no test: the fits with an offset for each window.
absl::StatusOr<OutputErrorFit> FitAllElements(
    const ProcessModel& initial, const std::vector<Record>& records,
    const OutputErrorOptions& options);

// The information bound (of Cramér and Rao) of the full parametric model with
// known noise and free offsets, given these samples: what no unbiased estimate
// of all its parameters can beat if the plant is `truth` and its outputs have
// this noise (one for each). An estimate that knows which parameters have not
// changed can. Its standard errors and ExpectedSquaredDistance() are the
// bound's; the records' outputs do not matter, except where they are missing.
absl::StatusOr<OutputErrorFit> ComputeOutputErrorLimit(
    const ProcessModel& truth, const std::vector<Record>& records,
    const std::vector<NoiseEstimate>& noise, const OutputErrorOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_ERROR_CORRECTION_H_
