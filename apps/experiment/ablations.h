// The experiment with one decision taken differently, to show what each is
// worth (docs/method.md): an axis of a campaign.

#ifndef APPS_EXPERIMENT_ABLATIONS_H_
#define APPS_EXPERIMENT_ABLATIONS_H_

#include <string>

#include "absl/types/span.h"
#include "apps/experiment/options.h"

namespace mle::experiment {

// One decision, by its name. `apply` changes options whose selection rule and
// solver are those of the method.
struct Ablation {
  const char* name;
  const char* what;  // in a few words
  void (*apply)(ExperimentOptions& options);
};

absl::Span<const Ablation> Ablations();

// Null if there is none of that name.
const Ablation* FindAblation(const std::string& name);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_ABLATIONS_H_
