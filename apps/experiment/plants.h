// The plants of a campaign: models drawn at random, and models that have aged.

#ifndef APPS_EXPERIMENT_PLANTS_H_
#define APPS_EXPERIMENT_PLANTS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "mle/model/process_model.h"

namespace mle::experiment {

// The plant of a seed: the first draw that is within the bounds for every
// controller. FailedPrecondition if there is none among a thousand.
absl::StatusOr<ProcessModel> DrawModel(
    const RandomPlants& plants, std::uint64_t seed,
    const std::vector<ControllerSpec>& controllers);

// Whether the changes are possible for every draw: the elements are there, and
// no dead time can fall below zero.
absl::Status CheckAgeing(const ProcessModel& model, const Mismatch& mismatch);

// The plant under a mismatch; what is drawn belongs to the seed.
// InvalidArgument where a change is not possible.
absl::StatusOr<ProcessModel> AgeModel(const ProcessModel& model,
                                      const Mismatch& mismatch,
                                      std::uint64_t seed);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_PLANTS_H_
