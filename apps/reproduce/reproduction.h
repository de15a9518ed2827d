// The paper's experiments as a campaign: its cases are mismatches, and its
// ablations and estimators are run on the same grid of seeds.

#ifndef APPS_REPRODUCE_REPRODUCTION_H_
#define APPS_REPRODUCE_REPRODUCTION_H_

#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {

struct Reproduction {
  // One model, noise, controller, solver and windows; a plant for each
  // mismatch; no methods, which RunReproduction() adds. The first selection is
  // the rule for λ.
  experiment::Campaign campaign;
  bool from_paper = false;  // the paper's figures belong beside the results
  std::vector<experiment::Method> estimators;  // to be compared
  int ablation_seeds = 5;                      // the first of the seeds, ≥ 1
  int threads = 0;                             // 0: one for each processor

  // Options of every run, but for ablations.
  absl::StatusOr<experiment::ExperimentOptions> Options() const;
};

// The results, case by case and seed by seed, do not depend on the threads.
// Only a case's first run keeps its curves. Errors name case and seed; what an
// estimator or an ablation cannot do stands in its result, and is none.
absl::StatusOr<std::vector<CaseResult>> RunReproduction(
    const Reproduction& reproduction);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_REPRODUCTION_H_
