// The request that mle_simulate carries out.

#ifndef APPS_SIMULATE_REQUEST_H_
#define APPS_SIMULATE_REQUEST_H_

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "control/mpc_options.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "sim/closed_loop.h"
#include "sim/plant_conditions.h"
#include "sim/plant_model.h"
#include "sim/set_point_profile.h"

namespace mle::simulate {

// One run of mle_simulate: a plant under a controller with a model of the
// plant.

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
  // Where channels with a transform are at rest (m, p), 0 of others: what is
  // simulated are deviations from there, and the record has both together.
  Eigen::VectorXd operating_inputs;
  Eigen::VectorXd operating_outputs;
};

// InvalidArgument for settings that do not fit together, FailedPrecondition for
// a loop that diverges.
absl::StatusOr<Record> Run(Simulation& simulation);

struct Request {
  // Options as they are given.
  std::string model_path;
  std::string plant = "";  // a process model's path, a plant's name, or empty
  std::vector<double> operating_inputs;  // of a plant by name; empty: its own
  std::string ageing_path;
  double age = 0.0;
  std::string set_points;
  std::string disturbances;
  std::string effects_path;
  std::string out;

  // A plant in memory, in place of the one that a path names.
  std::optional<ProcessModel> plant_model;

  // Where all others are; its model and plant are what the paths name.
  Simulation simulation;
};

// Both must outlive the program's flags.
void AddOptions(Request& request, OptionTable& table);

// Reads the files and checks everything that can be checked before something is
// run; errors name the option or the file.
absl::Status Complete(Request& request, OptionTable& table);

// The same where simulation.model is there already, and no file is written.
absl::Status CompleteForModel(Request& request, OptionTable& table);

// NAME:TIME:VALUE,… on a command line: steps of named channels.

struct NamedStep {
  int channel = 0;  // of `names`
  double time = 0.0;
  double value = 0.0;
};

// Names may hold colons. InvalidArgument, naming flag and entry, for an unknown
// name, or a time or value that is not a finite number.
absl::StatusOr<std::vector<NamedStep>> ParseNamedSteps(
    std::string_view flag, std::string_view value,
    const std::vector<std::string>& names);

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_REQUEST_H_
