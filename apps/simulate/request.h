// The request that mle_simulate carries out.

#ifndef APPS_SIMULATE_REQUEST_H_
#define APPS_SIMULATE_REQUEST_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "apps/simulate/simulation.h"

namespace mle::simulate {

struct Request {
  // Options as they are given.
  std::string model_path;
  std::string plant = "";  // a process model's path, van_de_vusse, or empty
  std::vector<double> operating_inputs = {8.0, -1113.5};
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

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_REQUEST_H_
