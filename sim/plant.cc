#include "sim/plant.h"

#include <utility>

#include "mle/base/status.h"

namespace mle::sim {

absl::StatusOr<Plant> Plant::Create(const ProcessModel& model,
                                    const PlantOptions& options) {
  MLE_ASSIGN_OR_RETURN(ProcessSimulator simulator,
                       ProcessSimulator::Create(model, options.sample_time));
  return Plant(std::move(simulator));
}

Plant::Plant(ProcessSimulator simulator) : simulator_(std::move(simulator)) {}

}  // namespace mle::sim
