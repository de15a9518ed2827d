// Validation of a correction: how well the initial and the corrected model
// predict held-out data, and whether their residuals are white and uncorrelated
// with the inputs.
//
// Hold-out validation is nested: of every window two of ten blocks are hidden
// at a time, others in the next window, and what predicts them is estimated
// from the rest alone, with its own noise, penalty and choice of elements. That
// a change is proposed, of what kind, and beside which AR component, sinusoids
// and steps is given, and fits begin where that to all windows ended. Nothing
// of what is scored had a part in anything else that predicts it, but every
// set-point change had: where each window moves the plant in one direction, the
// others determine nothing of it. One window of few set-point changes is not
// held out: its blocks have one disturbance.
//
// A correction that helps in one window and harms in another is of a plant that
// changed in between, or is not linear: each window has scores of its own.
//
// The scores of each output and horizon h (one step, a fifth of the ARX order,
// and free simulation, its mean error taken off) are, with the errors ε₀ and
// ε_c of the two models and S = Σ ε²,
//
//   fit = 100 (1 − ‖ε‖ / ‖y − ȳ‖) percent,    gain = 1 − S_c / S₀,
//
// ȳ the mean of each window. S₀ − S_c = Σ x (ε₀ + ε_c), x = ε₀ − ε_c the
// difference of the two predictions, of which only ε is random, so that the
// standard error of S₀ − S_c is 2 √(Σ_b (Σ_{k∈b} x_k ε_k)²) with ε of the
// better model; blocks b are a tenth, a third and the whole of a window, and
// the largest of the three counts: errors that last longer than a block would
// let it look too small. (Diebold and Mariano, J. Bus. Econ. Stat. 13, 1995.)
//
// The residuals are one-step prediction errors. Autocorrelation of output i at
// lag τ, pooled over windows,
//
//   r_e(τ) = Σ_k e_k e_{k+τ} / Σ_k e_k²,  within ±2.576/√N (99 %) if white,
//
// and Ljung and Box's Q = N (N + 2) Σ_{τ=1}^{L} r_e(τ)²/(N − τ), χ² with L
// degrees of freedom. (Biometrika 65, 1978; degrees of freedom are not reduced
// by the fitted parameters, few against L: p-values are slightly too large.)
//
// Cross-correlation with input j at lag τ, e later than u where τ > 0,
//
//   r_eu(τ) = Σ_k e_{k+τ} u_k / √(Σ e² Σ u²),
//
// with limits 2.576 √(Σ_s r_e(s) r_u(s) / N) (Bartlett). At τ ≤ 0 it shows
// feedback: an input of a closed loop answers to earlier outputs, and to the
// sample measured just before it moves. At τ > 0 it shows dynamics that the
// model lacks. Those lags are judged together: the errors are regressed on the
// input's means over kTestLags segments of lags, N R² is χ² with as many
// degrees of freedom if the errors are white (Ljung, System Identification,
// 1999, sec. 16.6).

#ifndef MLE_MAINTAIN_VALIDATION_H_
#define MLE_MAINTAIN_VALIDATION_H_

#include <limits>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/message.h"

namespace mle {

struct HoldOutOptions {
  int folds = 5;    // ≥ 2
  int horizon = 0;  // samples, of the k-step fit; 0: a fifth of the ARX order
  // Set-point changes that a window must have if it is the only one, ≥ 2.
  int fewest_changes = 4;

  absl::Status Validate() const;
};

// Scores of one output at one horizon. NaN where nothing was scored.
struct HorizonScore {
  double initial = std::numeric_limits<double>::quiet_NaN();    // fit, percent
  double corrected = std::numeric_limits<double>::quiet_NaN();  // fit, percent
  double gain = std::numeric_limits<double>::quiet_NaN();
  double error = std::numeric_limits<double>::quiet_NaN();  // of the gain
};

struct OutputScores {
  HorizonScore one_step;
  HorizonScore several_steps;
  HorizonScore simulated;
};

struct Validation {
  bool held_out = false;
  int horizon = 0;                 // of several_steps, in samples
  std::vector<std::string> folds;  // what each held out, in words
  std::string missing;             // why nothing was held out
  // p: what was held out or, where nothing was, all windows by the initial
  // model, without a gain.
  std::vector<OutputScores> outputs;
  // Those of each window, as of `outputs`; empty where nothing was held out.
  std::vector<std::vector<OutputScores>> windows;
};

// `windows` are those of the estimate, `changes` the set-point changes in the
// first of them, `order` (> 0) that of the ARX model. `in_use` are the errors
// of the controller's own model where this is not the process model, or empty.
// Cancelled by `progress`.
absl::StatusOr<Validation> ValidateByHoldOut(
    const Estimate& estimate, const std::vector<Record>& windows, int changes,
    int order, const HoldOutOptions& options, const Predictor& in_use = {},
    int threads = 1, const ProgressCallback& progress = {});

inline constexpr double kDiagnosticLevel = 0.01;  // of the limits: 99 %
inline constexpr int kTestLags = 20;

struct InputCorrelation {
  int max_lag = 0;
  Eigen::VectorXd values;  // r_eu(τ), τ = −max_lag … max_lag
  double limit = 0.0;      // 99 %
  // The largest |r_eu| at a lag above 0, and where.
  double largest = 0.0;
  int largest_lag = 0;
  double statistic = 0.0;  // N R²
  int degrees_of_freedom = 0;
  double p_value = 1.0;  // 1 for an input that does not move

  bool correlated() const { return p_value < kDiagnosticLevel; }
};

struct ResidualReport {
  int samples = 0;  // N
  double variance = 0.0;
  Eigen::VectorXd autocorrelation;  // τ = 1 … L
  double limit = 0.0;               // 99 %
  double outside = 0.0;             // share of them beyond the limit
  double ljung_box = 0.0;
  int degrees_of_freedom = 0;
  double p_value = 1.0;
  std::vector<InputCorrelation> inputs;  // m

  bool white() const { return p_value >= kDiagnosticLevel; }
};

// One for each output. `max_lag` ≥ 1 in samples; shorter where windows are.
std::vector<ResidualReport> ExamineResiduals(const Predictor& predictor,
                                             const std::vector<Record>& windows,
                                             int max_lag, int threads = 1);

}  // namespace mle

#endif  // MLE_MAINTAIN_VALIDATION_H_
