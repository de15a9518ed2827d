#include "sim/input_disturbance.h"

#include <cmath>

#include "mle/base/random.h"
#include "mle/base/status.h"
#include "sim/check_options.h"
#include "sim/coloured_noise.h"
#include "sim/set_point_profile.h"

namespace mle::sim {

absl::Status InputDisturbanceOptions::Validate(
    const ProcessModel& channels) const {
  for (const InputStep& step : steps) {
    if (step.input < 0 || step.input >= channels.num_inputs()) {
      return InvalidArgument("step of a disturbance: input = ", step.input,
                             ", but it must be one of 0 … ",
                             channels.num_inputs() - 1);
    }
    const InputChannel& channel = channels.inputs()[step.input];
    if (channel.role != InputRole::kDisturbance) {
      return InvalidArgument(
          "step of a disturbance: input '", channel.name,
          "' is moved by the controller; its role must be disturbance");
    }
    if (!std::isfinite(step.time) || !std::isfinite(step.value)) {
      return InvalidArgument("step of disturbance '", channel.name,
                             "': time = ", step.time, ", value = ", step.value,
                             ", but both must be finite");
    }
  }
  MLE_RETURN_IF_ERROR(
      CheckNoneOrNotNegative("variance", variance, channels.num_inputs()));
  return CheckPositive("time_constant", time_constant);
}

Eigen::MatrixXd DrawInputDisturbances(const InputDisturbanceOptions& options,
                                      const ProcessModel& channels,
                                      double sample_time, int samples,
                                      std::uint64_t seed,
                                      std::uint64_t stream) {
  const int m = channels.num_inputs();
  SetPointProfile profile;
  for (const InputStep& step : options.steps) {
    profile.steps.push_back({step.input, step.time, step.value});
  }
  Eigen::MatrixXd inputs = profile.Sample(m, sample_time, samples);
  if (options.variance.size() != 0) {
    Eigen::VectorXd deviation = options.variance.cwiseSqrt();
    for (int j = 0; j < m; ++j) {
      if (channels.inputs()[j].role != InputRole::kDisturbance) {
        deviation[j] = 0.0;
      }
    }
    GaussianNoise source(seed, stream, kInputDisturbance);
    inputs += DrawColouredNoise(source, deviation, options.time_constant,
                                sample_time, samples);
  }
  return inputs;
}

}  // namespace mle::sim
