// How well the initial and the corrected model predict what the correction has
// not seen.
//
// With two windows or more, each is held out in turn (at most `max_folds`
// groups of them), the estimator fitted to the others, and its model predicts
// the one held out. With a single window, five times every fifth of its blocks
// is held out: the outputs there are hidden from the fit. The fit of a model in
// percent is
//
//   100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖)
//
// over the samples held out, ȳ the mean of each window. Both models start from
// measured outputs every h samples: one, a fifth of the ARX order, or never
// (simulation, its mean error taken off).

#ifndef APPS_CORRECT_VALIDATION_H_
#define APPS_CORRECT_VALIDATION_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/correct/estimation.h"
#include "apps/correct/records.h"

namespace mle::correct {

struct ValidationOptions {
  int max_folds = 5;  // ≥ 2
  int horizon = 0;    // samples, of the k-step fit; 0: a fifth of the ARX order
  int order = 0;      // of the ARX model, > 0
  int threads = 1;
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

struct FoldSummary {
  std::string held_out;          // in words
  bool change_proposed = false;  // by the fit that has not seen it
};

struct Validation {
  bool blocked = false;  // parts of a single window were held out
  int horizon = 0;       // of several_steps, in samples
  std::vector<FoldSummary> folds;
  std::vector<OutputValidation> outputs;  // p
  // Σ_i −½ N_i ln(S_i corrected / S_i initial), S_i the sum of squared errors
  // of output i over `horizon`: what the corrected model gains in likelihood if
  // its errors were independent. They are not, but the sign stands.
  double gain = 0.0;
  // Why there are no figures; empty where there are.
  std::string missing;

  bool available() const { return missing.empty(); }
  // The corrected model predicts what it has not seen worse than the initial.
  bool worsens() const { return available() && gain < 0.0; }
};

absl::StatusOr<Validation> Validate(const Setting& setting,
                                    const RecordData& data,
                                    const ValidationOptions& options);

}  // namespace mle::correct

#endif  // APPS_CORRECT_VALIDATION_H_
