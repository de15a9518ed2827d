// Every case run with every seed, each pair a run of its own.

#ifndef APPS_REPRODUCE_STUDY_H_
#define APPS_REPRODUCE_STUDY_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/reproduce/ablations.h"
#include "apps/reproduce/experiment.h"
#include "apps/reproduce/summary.h"
#include "mle/model/process_model.h"

namespace mle::reproduce {

struct Case {
  std::string name;         // goes into names of files
  ProcessModel plant;       // of the same channels as the initial model
  bool from_paper = false;  // the paper's figures belong beside the results
};

struct Study {
  ProcessModel initial;
  std::vector<Case> cases;  // not empty, names differ
  ExperimentOptions experiment;
  std::vector<const Ablation*> ablations;
  int ablation_seeds = 5;        // the first of the seeds, ≥ 1
  int seeds = 1;                 // ≥ 1
  std::uint64_t first_seed = 1;  // the others follow it
  int threads = 0;               // 0: one for each processor
};

// The results, case by case and seed by seed, do not depend on the threads. A
// conversion serves all cases of its seed. Only a case's first run keeps its
// curves: those of all seeds would fill the memory. Errors name case and seed.
absl::StatusOr<std::vector<CaseResult>> RunStudy(const Study& study);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_STUDY_H_
