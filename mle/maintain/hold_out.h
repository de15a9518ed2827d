// How well the initial and the corrected model predict what the correction has
// not seen.
//
// Nested: of every window two of ten blocks are hidden at a time, others in the
// next window, and what predicts them is estimated from the rest alone, with
// its own noise, penalty and choice of elements. That a change is proposed, of
// what kind, and beside which AR component, sinusoids and steps is given, and
// fits begin where that to all windows ended. Nothing of what is scored had a
// part in anything else that predicts it, but every set-point change had: where
// each window moves the plant in one direction, the others determine nothing of
// it. One window of few set-point changes is not held out: its blocks have one
// disturbance.
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

#ifndef MLE_MAINTAIN_HOLD_OUT_H_
#define MLE_MAINTAIN_HOLD_OUT_H_

#include <limits>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/prediction.h"
#include "mle/maintain/progress.h"

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

}  // namespace mle

#endif  // MLE_MAINTAIN_HOLD_OUT_H_
