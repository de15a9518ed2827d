#include "sim/closed_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "sim/noise.h"
#include "sim/plant.h"
#include "sim/sampling.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRunawayFactor = 1e6;

int SamplesPerControlPeriod(const ClosedLoopOptions& options) {
  return static_cast<int>(
      std::round(options.control_period / options.sample_time));
}

struct RunawayLimits {
  VectorXd outputs;  // p
  VectorXd inputs;   // m, infinite for an input without static effect
};

RunawayLimits ComputeRunawayLimits(const ProcessModel& plant,
                                   const MatrixXd& set_points,
                                   double noise_deviation) {
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  VectorXd size =
      set_points.cwiseAbs().rowwise().maxCoeff().cwiseMax(noise_deviation);
  if (size.maxCoeff() == 0.0) size.setOnes();

  RunawayLimits limits{size, VectorXd(m)};
  for (int j = 0; j < m; ++j) {
    double input_size = 0.0;
    bool has_effect = false;
    for (int i = 0; i < p; ++i) {
      const double gain = std::abs(plant.element(i, j).StaticGain());
      if (gain == 0.0) continue;
      has_effect = true;
      input_size = std::max(input_size, size[i] / gain);
    }
    limits.inputs[j] = has_effect ? kRunawayFactor * input_size
                                  : std::numeric_limits<double>::infinity();
    for (int i = 0; i < p; ++i) {
      const double gain = std::abs(plant.element(i, j).StaticGain());
      limits.outputs[i] = std::max(limits.outputs[i], gain * input_size);
    }
  }
  limits.outputs *= kRunawayFactor;
  return limits;
}

template <typename Channel>
absl::Status CheckWithin(const std::vector<Channel>& channels,
                         const VectorXd& values, const VectorXd& limits,
                         const char* kind, double time) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && std::abs(values[i]) <= limits[i]) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "the closed loop runs away: ", kind, " '", channels[i].name, "' is ",
        values[i], " at time ", time, ", beyond ±", limits[i],
        "; the controller does not stabilise this plant"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ClosedLoopOptions::Validate() const {
  MLE_RETURN_IF_ERROR(ValidateSampling(sample_time, duration));
  const double ratio = control_period / sample_time;
  if (!(ratio >= 1.0 - 1e-9) || ratio > 1e9 ||
      std::abs(ratio - std::round(ratio)) > 1e-9 * ratio) {
    return absl::InvalidArgumentError(absl::StrCat(
        "control_period = ", control_period,
        ", but it must be a whole multiple of sample_time = ", sample_time));
  }
  return ValidateNoiseVariance(noise_variance);
}

absl::StatusOr<Record> SimulateClosedLoop(const ProcessModel& plant_model,
                                          const Controller& controller,
                                          const SetPointProfile& set_points,
                                          const ClosedLoopOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(
      Plant plant,
      Plant::Create(plant_model, {.sample_time = options.sample_time}));
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  MLE_RETURN_IF_ERROR(set_points.Validate(p));

  const int samples = SampleCount(options.sample_time, options.duration);
  const int samples_per_period = SamplesPerControlPeriod(options);
  const double noise_deviation = std::sqrt(options.noise_variance);
  GaussianNoise noise(options.seed, options.stream);
  Record record;
  record.sample_time = options.sample_time;
  record.set_points = set_points.Sample(p, options.sample_time, samples);
  record.outputs = noise.DrawMatrix(p, samples, noise_deviation);
  record.inputs.resize(m, samples);
  const RunawayLimits limits =
      ComputeRunawayLimits(plant_model, record.set_points, noise_deviation);

  VectorXd input = VectorXd::Zero(m);
  VectorXd next_input = VectorXd::Zero(m);
  for (int k = 0; k < samples; ++k) {
    MLE_RETURN_IF_ERROR(CheckWithin(plant_model.outputs(), plant.outputs(),
                                    limits.outputs, "output", record.time(k)));
    record.outputs.col(k) += plant.outputs();
    if (k % samples_per_period == 0) {
      input = next_input;
      MLE_RETURN_IF_ERROR(CheckWithin(plant_model.inputs(), input,
                                      limits.inputs, "input", record.time(k)));
      controller(record.outputs.col(k), record.set_points.col(k), next_input);
    }
    record.inputs.col(k) = input;
    plant.Advance(input);
  }
  return record;
}

}  // namespace mle::sim
