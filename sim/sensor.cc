#include "sim/sensor.h"

#include <algorithm>
#include <cmath>

#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {

namespace {

double Bend(const SensorOptions& sensor, double value) {
  const double a = sensor.curvature;
  if (a == 0.0) return value;
  switch (sensor.curve) {
    case OutputCurve::kNone:
      return value;
    case OutputCurve::kQuadratic:
      return value + a * value * value;
    case OutputCurve::kLogarithm:
      // Far below the operating point it stays at a hundredth.
      return std::log(std::max(1.0 + a * value, 0.01)) / a;
    case OutputCurve::kTanh:
      return std::tanh(a * value) / a;
  }
  return value;
}

}  // namespace

absl::Status SensorOptions::Validate(int num_outputs) const {
  if (output < 0 || output >= num_outputs) {
    return InvalidArgument("sensor: output = ", output,
                           ", but it must be one of 0 … ", num_outputs - 1);
  }
  if (!std::isfinite(curvature)) {
    return InvalidArgument("curvature = ", curvature,
                           ", but it must be finite");
  }
  MLE_RETURN_IF_ERROR(CheckNotNegative("lag", lag));
  MLE_RETURN_IF_ERROR(CheckNotNegative("noise_variance", noise_variance));
  if (!(min <= max)) {
    return InvalidArgument("sensor: min = ", min,
                           ", but it must be at most max = ", max);
  }
  if (std::isnan(dead_from)) {
    return absl::InvalidArgumentError("sensor: dead_from is nan");
  }
  return absl::OkStatus();
}

Lag::Lag(double time_constant, double sample_time) {
  if (time_constant == 0.0) {
    memory_ = past_ = 0.0;
    return;
  }
  const double ratio = sample_time / time_constant;
  memory_ = std::exp(-ratio);
  past_ = -std::expm1(-ratio) / ratio - memory_;
}

double Lag::Follow(double signal) {
  response_ = started_ ? memory_ * response_ + past_ * signal_ +
                             (1.0 - memory_ - past_) * signal
                       : signal;
  signal_ = signal;
  started_ = true;
  return response_;
}

Sensors::Sensors(const std::vector<SensorOptions>& options, double sample_time)
    : options_(options), sample_time_(sample_time), shown_(options.size()) {
  for (const SensorOptions& sensor : options) {
    lags_.emplace_back(sensor.lag, sample_time);
  }
}

void Sensors::Follow(Eigen::Ref<Eigen::VectorXd> outputs) {
  for (std::size_t s = 0; s < options_.size(); ++s) {
    double& output = outputs[options_[s].output];
    output = lags_[s].Follow(Bend(options_[s], output));
  }
}

void Sensors::FollowAll(Eigen::Ref<Eigen::MatrixXd> signals) const {
  for (const SensorOptions& sensor : options_) {
    Lag lag(sensor.lag, sample_time_);
    for (double& value : signals.row(sensor.output)) value = lag.Follow(value);
  }
}

void Sensors::Show(double time, Eigen::Ref<Eigen::VectorXd> outputs) {
  for (std::size_t s = 0; s < options_.size(); ++s) {
    const SensorOptions& sensor = options_[s];
    double& output = outputs[sensor.output];
    if (time < sensor.dead_from) {
      shown_[s] = std::clamp(output, sensor.min, sensor.max);
    }
    output = shown_[s];
  }
}

}  // namespace mle::sim
