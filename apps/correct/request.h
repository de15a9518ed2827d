// What the flags ask for.

#ifndef APPS_CORRECT_REQUEST_H_
#define APPS_CORRECT_REQUEST_H_

#include <optional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "mle/data/historian.h"
#include "mle/maintain/correct.h"
#include "mle/model/process_model.h"

namespace mle::correct {

// The controller as it is tuned, for the advice. Times in the model's unit.
struct ControllerSettings {
  double control_period = 0.0;    // 0: not told
  int prediction_horizon = 0;     // in periods
  int control_horizon = 0;        // in periods
  Eigen::VectorXd output_weight;  // p
  Eigen::VectorXd move_weight;    // m
  double disturbance_variance_ratio = 0.1;

  bool known() const { return control_period > 0.0; }
};

struct Request {
  std::string model_path;
  ProcessModel model;
  std::vector<std::string> data_paths;
  std::string out;
  std::string truth_path;  // empty: none
  std::optional<ProcessModel> truth;
  HistorianOptions import;
  CorrectOptions options;
  ControllerSettings controller;
  bool dry_run = false;
  bool figures = true;
};

}  // namespace mle::correct

#endif  // APPS_CORRECT_REQUEST_H_
