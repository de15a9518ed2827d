#include "sim/plant_conditions.h"

#include <cmath>

#include "mle/base/status.h"

namespace mle::sim {
namespace {

absl::Status CheckLimits(const char* field, const Eigen::VectorXd& limits,
                         int num_inputs) {
  if (limits.size() != 0 && limits.size() != num_inputs) {
    return InvalidArgument("valves: ", field, " has ", limits.size(),
                           " values, but it needs ", num_inputs, " or none");
  }
  if (limits.hasNaN()) {
    return InvalidArgument("valves: ", field, " is nan for an input");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValveLimits::Validate(int num_inputs) const {
  MLE_RETURN_IF_ERROR(CheckLimits("min", min, num_inputs));
  MLE_RETURN_IF_ERROR(CheckLimits("max", max, num_inputs));
  if (min.size() == 0 || max.size() == 0) return absl::OkStatus();
  for (int j = 0; j < num_inputs; ++j) {
    if (min[j] <= max[j]) continue;
    return InvalidArgument("valves: input ", j, " has min = ", min[j],
                           " above max = ", max[j]);
  }
  return absl::OkStatus();
}

double ValveLimits::Limit(int input, double value) const {
  // A value that is no number passes, to be noticed.
  if (min.size() != 0 && value < min[input]) return min[input];
  if (max.size() != 0 && value > max[input]) return max[input];
  return value;
}

absl::Status ManualPeriod::Validate(const ProcessModel& channels) const {
  if (input < 0 || input >= channels.num_inputs() ||
      channels.inputs()[input].role == InputRole::kDisturbance) {
    return InvalidArgument("input = ", input,
                           " in manual, but it must be one that is moved");
  }
  if (from < to && std::isfinite(from) && std::isfinite(change)) {
    return absl::OkStatus();
  }
  return InvalidArgument(
      "manual from ", from, " to ", to, " with change = ", change,
      ", but it must end after it begins, with a finite change");
}

absl::Status PlantConditions::Validate(const ProcessModel& channels) const {
  MLE_RETURN_IF_ERROR(output_disturbance.Validate(channels.num_outputs()));
  MLE_RETURN_IF_ERROR(input_disturbance.Validate(channels));
  for (const InputLoad& load : loads) {
    MLE_RETURN_IF_ERROR(load.Validate(channels.num_inputs()));
  }
  MLE_RETURN_IF_ERROR(valves.Validate(channels.num_inputs()));
  for (const ManualPeriod& period : manual) {
    MLE_RETURN_IF_ERROR(period.Validate(channels));
  }
  for (const ActuatorOptions& actuator : actuators) {
    MLE_RETURN_IF_ERROR(actuator.Validate(channels));
  }
  for (const SensorOptions& sensor : sensors) {
    MLE_RETURN_IF_ERROR(sensor.Validate(channels.num_outputs()));
  }
  MLE_RETURN_IF_ERROR(faults.Validate(channels.num_outputs()));
  return archive.Validate(channels.num_outputs(), channels.num_inputs());
}

}  // namespace mle::sim
