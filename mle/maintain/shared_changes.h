// Changes that all elements of an output, or of an input, share.
//
// A tag whose time stamps are late looks like longer dead times in its whole
// row or column of the model, and no record tells one from the other: an
// analyser's sample line and a historian's clock do the same. A valve at
// another place of a curved characteristic looks like a factor of all gains of
// its column. With the estimates θ_j ± σ_j of the fitted elements, two or more,
// the shared change is
//
//   δ = Σ w_j (θ_j − θ_j0) / Σ w_j,   w_j = 1/(σ_j² + ε²),
//
// where every θ_j − θ_j0 lies within 3/√w_j of δ, |δ| is beyond three of its
// own standard errors, and all are nearer to δ than to 0, or, of dead times,
// two or more speak for δ by 2 nats and none by as much against it; θ are dead
// times, ε a quarter of a sample, or gains relative to those of the model,
// ε 1 %. A dead time that has come out as 0 would have been shorter still: it
// has no say in δ, and does not speak against one below its own change.
// tag_clocks.h asks the same of dead times before anything is fitted, of
// records that nothing else explains better; this asks it of the estimates.

#ifndef MLE_MAINTAIN_SHARED_CHANGES_H_
#define MLE_MAINTAIN_SHARED_CHANGES_H_

#include <optional>
#include <string>
#include <vector>

#include "mle/nonlinear/output_error_correction.h"

namespace mle {

struct SharedDelay {
  bool is_output = false;
  int channel = 0;
  double change = 0.0;  // δ, in the model's time unit
  double error = 0.0;   // standard error
  // A dead time would have to be negative: it is the clock.
  bool impossible = false;

  bool contains(int output, int input) const {
    return channel == (is_output ? output : input);
  }
  const std::string& Channel(const ProcessModel& model) const;  // its name
  // "All dead times to top are 0.6 min longer: …"
  std::string Describe(const ProcessModel& model) const;
};

// By which the gains of all elements of an input have changed, relative to
// themselves.
std::optional<double> FindSharedGain(const OutputErrorFit& fit, int input);

// Of rows first; of columns those without a row that has one. `fit` is of
// records sampled every `sample_time`.
std::vector<SharedDelay> FindSharedDelays(const OutputErrorFit& fit,
                                          double sample_time);

}  // namespace mle

#endif  // MLE_MAINTAIN_SHARED_CHANGES_H_
