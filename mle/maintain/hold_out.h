// How well the initial and the corrected model predict what the correction has
// not seen.
//
// Two ways of holding out, both only where a change is proposed:
//
//   windows  each is held out in turn (at most `max_folds` groups of them): a
//            correction made from some set-point changes predicts the others.
//   blocks   ten blocks of each window, two at a time, are hidden from the fit:
//            a correction that has seen parts of every change predicts the
//            rest. For arx the rule for λ has held blocks out already: its
//            loss at λ* and without correction is compared.
//
// A correction that predicts worse in either way is refused (decision.h).
//
// The fit of a model in percent is
//
//   100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖)
//
// over the samples held out, ȳ the mean of each window. Both models start from
// measured outputs every h samples: one, a fifth of the ARX order, or never
// (simulation, its mean error taken off).

#ifndef MLE_MAINTAIN_HOLD_OUT_H_
#define MLE_MAINTAIN_HOLD_OUT_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/progress.h"

namespace mle {

struct HoldOutOptions {
  int max_folds = 5;  // ≥ 2
  int horizon = 0;    // samples, of the k-step fit; 0: a fifth of the ARX order

  absl::Status Validate() const;
};

// In percent; NaN where nothing could be scored.
struct FitPercent {
  double one_step = 0.0;
  double several_steps = 0.0;
  double simulated = 0.0;
};

struct OutputValidation {
  FitPercent initial;
  FitPercent corrected;
};

// One way of holding out.
struct HeldOut {
  std::vector<std::string> folds;         // what each held out, in words
  std::vector<OutputValidation> outputs;  // p, or empty: no figures
  // Σ_i −½ N_i ln(S_i corrected / S_i initial), S_i the sum of squared errors
  // of output i: what the corrected model gains in log-likelihood. One step
  // ahead where the model is structured, whose predictor is made for its noise;
  // simulated for outputs that are ΔR's, which predicts well a few samples
  // ahead even where its step responses are wrong.
  double gain = 0.0;
  std::string missing;  // why no data could be held out

  bool available() const { return missing.empty(); }
};

struct Validation {
  int horizon = 0;                 // of several_steps, in samples
  std::optional<HeldOut> windows;  // where there are two or more
  std::optional<HeldOut> blocks;   // where a change is proposed
  // The initial model on all windows, where no change is proposed.
  std::vector<FitPercent> initial;  // p

  // The least log-likelihood gain of the ways that were possible; nothing where
  // none was.
  std::optional<double> WorstGain() const;
  // What is shown: windows where there are such figures, else blocks.
  const HeldOut* shown() const;
};

// `windows` are those of the estimate, `order` (> 0) is that of the ARX model.
// Cancelled by `progress`.
absl::StatusOr<Validation> ValidateByHoldOut(
    const Estimate& estimate, const std::vector<Record>& windows, int order,
    const HoldOutOptions& options, int threads = 1,
    const ProgressCallback& progress = {});

}  // namespace mle

#endif  // MLE_MAINTAIN_HOLD_OUT_H_
