// One scenario of a campaign as the experiment of mle_reproduce knows it.

#ifndef APPS_STUDY_SCENARIO_H_
#define APPS_STUDY_SCENARIO_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/reproduce/experiment.h"
#include "apps/study/campaign.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle::study {

// Indices into the campaign's lists.
struct Scenario {
  int model = 0;
  int noise = 0;
  int drift = 0;
  int controller = 0;
  int windows = 0;
  int mismatch = 0;
};

// For a model of so many channels. InvalidArgument if weights do not fit.
absl::StatusOr<reproduce::ExperimentOptions> OptionsOf(const Campaign& campaign,
                                                       const Scenario& scenario,
                                                       int outputs, int inputs);

// What can be known before anything is run: that the options of every model,
// controller and windows belong together.
absl::Status CheckScenarios(const Campaign& campaign);

// The records of the closed loop around the set-point changes.
absl::StatusOr<std::vector<Record>> SimulateChanges(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const WindowSpec& windows, const reproduce::ExperimentOptions& options);

}  // namespace mle::study

#endif  // APPS_STUDY_SCENARIO_H_
