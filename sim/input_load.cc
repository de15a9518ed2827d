#include "sim/input_load.h"

#include <cmath>

#include "mle/base/random.h"
#include "mle/base/status.h"
#include "sim/check_options.h"
#include "sim/coloured_noise.h"

namespace mle::sim {

absl::Status InputLoad::Validate(int num_inputs) const {
  if (input < 0 || input >= num_inputs) {
    return InvalidArgument("load: input = ", input,
                           ", but it must be one of 0 … ", num_inputs - 1);
  }
  for (const SignalStep& step : steps) MLE_RETURN_IF_ERROR(step.Validate());
  if (!std::isfinite(answered)) {
    return InvalidArgument("answered = ", answered, ", but it must be finite");
  }
  MLE_RETURN_IF_ERROR(CheckNotNegative("variance", variance));
  return CheckPositive("time_constant", time_constant);
}

Eigen::MatrixXd DrawInputLoads(const std::vector<InputLoad>& loads,
                               int num_inputs, double sample_time, int samples,
                               std::uint64_t seed, std::uint64_t stream) {
  Eigen::MatrixXd signals = Eigen::MatrixXd::Zero(num_inputs, samples);
  for (const InputLoad& load : loads) {
    if (load.variance > 0.0) {
      GaussianNoise source(seed, stream, kInputLoad + load.input);
      signals.row(load.input) += DrawColouredNoise(
          source, Eigen::VectorXd::Constant(1, std::sqrt(load.variance)),
          load.time_constant, sample_time, samples);
    }
    for (const SignalStep& step : load.steps) {
      AddStep(step, sample_time, signals.row(load.input));
    }
  }
  return signals;
}

}  // namespace mle::sim
