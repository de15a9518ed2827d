// Under which conditions a plant runs: what disturbs it, what its valves do and
// what becomes of its measurements. By default none of it.

#ifndef SIM_PLANT_CONDITIONS_H_
#define SIM_PLANT_CONDITIONS_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/process_model.h"
#include "sim/actuator.h"
#include "sim/archive.h"
#include "sim/input_disturbance.h"
#include "sim/input_load.h"
#include "sim/measurement_faults.h"
#include "sim/output_disturbance.h"
#include "sim/sensor.h"

namespace mle::sim {

// The limits of the valves, whatever the controller asks for: a value for each
// input (m), infinite where there is no limit, or no values at all.
// Disturbances are not limited.
struct ValveLimits {
  Eigen::VectorXd min;  // ≤ max
  Eigen::VectorXd max;

  absl::Status Validate(int num_inputs) const;
  double Limit(int input, double value) const;
};

// An operator holds an input where it was before `from`, plus `change`, until
// `to`. While an input is in manual the controller waits: its set points follow
// the measurements. Afterwards what it asks for acts again, with a bump.
struct ManualPeriod {
  int input = 0;  // not a disturbance
  double from = 0.0;
  double to = 0.0;  // > from
  double change = 0.0;

  absl::Status Validate(const ProcessModel& channels) const;
};

struct PlantConditions {
  OutputDisturbanceOptions output_disturbance;
  InputDisturbanceOptions input_disturbance;
  std::vector<InputLoad> loads;
  ValveLimits valves;
  std::vector<ManualPeriod> manual;
  std::vector<ActuatorOptions> actuators;  // at most one for each input
  std::vector<SensorOptions> sensors;      // at most one for each output
  MeasurementFaultOptions faults;
  ArchiveOptions archive;

  absl::Status Validate(const ProcessModel& channels) const;
};

}  // namespace mle::sim

#endif  // SIM_PLANT_CONDITIONS_H_
