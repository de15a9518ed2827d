// The request to mle_reproduce, as its flags give it.

#ifndef APPS_REPRODUCE_REQUEST_H_
#define APPS_REPRODUCE_REQUEST_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "apps/experiment/campaign.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {

// The paper's experiments as a campaign: its cases are mismatches, and its
// ablations and estimators are run on the same grid of seeds.

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

// The Wood-Berry column's own cases.
inline constexpr char kPaperCases[] = "gain,delay";

struct Request {
  Request();

  // Options as they are given.
  std::string cases = kPaperCases;
  std::string model_path;
  std::string plants;
  int seeds = 1;
  std::uint64_t first_seed = 1;
  double lambda_grid_max = 1e-2;
  double lambda_grid_step = 1e-6;
  std::vector<std::string> estimators = {"arx", "ceres", "output_error"};
  std::vector<std::string> ablations;
  std::string folder = "results";
  bool figures = true;

  // Where all others are.
  Reproduction reproduction;
};

// Both must outlive the program's flags.
void AddOptions(Request& request, OptionTable& table);

// Reads the process models and checks everything that can be checked before
// something is run; errors name the option or the file.
absl::Status Complete(Request& request, OptionTable& table);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_REQUEST_H_
