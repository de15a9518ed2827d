// The options of the experiment: flags of mle_reproduce and keys of campaigns
// (docs/formats.md), which are called the same. The fields must outlive the
// options.

#ifndef APPS_EXPERIMENT_EXPERIMENT_OPTIONS_H_
#define APPS_EXPERIMENT_EXPERIMENT_OPTIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/options.h"

namespace mle::experiment {

// Sample time, order, response horizon and scaling.
std::vector<Option> OptionsOf(ExperimentOptions& settings);
// Duration, penalty and noise variance of the conversion.
std::vector<Option> ConversionOptionsOf(ExperimentOptions& settings);
std::vector<Option> OptionsOf(WindowSpec& windows);
std::vector<Option> OptionsOf(SelectionSpec& selection);
std::vector<Option> OptionsOf(RandomPlants& plants);
std::vector<Option> OptionsOf(Change& change);

// `count` ≥ 1 seeds from `first` on: --seeds and --first_seed.
absl::StatusOr<std::vector<std::uint64_t>> ConsecutiveSeeds(std::uint64_t first,
                                                            int count);

// A rule for λ, or a solver, and its name.
TextValue RuleOf(SelectionSpec* selection);
TextValue SolverOf(SolverSpec* solver);

// The options with `prefix` before their names.
std::vector<Option> Prefixed(const std::string& prefix,
                             std::vector<Option> options);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_EXPERIMENT_OPTIONS_H_
