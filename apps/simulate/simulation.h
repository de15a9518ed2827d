// One run of mle_simulate: a plant under a controller with a model of the
// plant.

#ifndef APPS_SIMULATE_SIMULATION_H_
#define APPS_SIMULATE_SIMULATION_H_

#include <memory>

#include "absl/status/statusor.h"
#include "control/mpc_options.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "sim/closed_loop.h"
#include "sim/plant_conditions.h"
#include "sim/plant_model.h"
#include "sim/set_point_profile.h"

namespace mle::simulate {

struct Simulation {
  ProcessModel model;  // of the controller
  // The plant at the beginning of the run.
  std::unique_ptr<sim::PlantModel> plant;
  control::MpcOptions controller;
  bool feed_forward = true;  // of measured disturbances
  bool preview = false;      // of set points
  sim::SetPointProfile set_points;
  sim::ClosedLoopOptions loop;
  sim::PlantConditions conditions;
};

// InvalidArgument for settings that do not fit together, FailedPrecondition for
// a loop that diverges.
absl::StatusOr<Record> Run(Simulation& simulation);

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_SIMULATION_H_
