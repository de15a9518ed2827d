#include "sim/actuator.h"

#include <algorithm>
#include <cmath>

#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {

absl::Status ActuatorOptions::Validate(const ProcessModel& channels) const {
  if (input < 0 || input >= channels.num_inputs()) {
    return InvalidArgument("actuator: input = ", input,
                           ", but it must be one of 0 … ",
                           channels.num_inputs() - 1);
  }
  const InputChannel& channel = channels.inputs()[input];
  if (channel.role == InputRole::kDisturbance) {
    return InvalidArgument(
        "actuator of '", channel.name,
        "': the input is a disturbance, which has no actuator");
  }
  MLE_RETURN_IF_ERROR(CheckNotNegative("stiction", stiction));
  MLE_RETURN_IF_ERROR(CheckNotNegative("jump", slip_jump));
  MLE_RETURN_IF_ERROR(CheckPositive("span", span));
  MLE_RETURN_IF_ERROR(CheckProbability("position", position));
  MLE_RETURN_IF_ERROR(CheckNotNegative("kink", kink));
  if (!std::isfinite(kink_slope)) {
    return InvalidArgument("kink_slope = ", kink_slope,
                           ", but it must be finite");
  }
  if (!(min <= 0.0 && max >= 0.0)) {
    return InvalidArgument(
        "min = ", min, " and max = ", max,
        ", but 0, the operating point, must lie between them");
  }
  if (!(rate > 0.0)) {
    return InvalidArgument("rate = ", rate, ", but it must be > 0");
  }
  if (rangeability >= 1.0 && std::isfinite(rangeability)) {
    return absl::OkStatus();
  }
  return InvalidArgument("rangeability = ", rangeability,
                         ", but it must be finite and ≥ 1");
}

double Actuator::EqualPercentage(double stem) const {
  const double range = std::log(options_.rangeability);
  if (range == 0.0) return stem;
  const double part = std::clamp(stem / options_.span, -options_.position,
                                 1.0 - options_.position);
  return options_.span * std::expm1(range * part) / range;
}

double Actuator::Characteristic(double stem) const {
  const double flow = EqualPercentage(stem);
  if (stem <= options_.kink) return flow;
  const double at_kink = EqualPercentage(options_.kink);
  return at_kink + options_.kink_slope * (flow - at_kink);
}

double Actuator::Move(double asked) {
  const double static_friction = (options_.stiction + options_.slip_jump) / 2.0;
  const double moving_friction = (options_.stiction - options_.slip_jump) / 2.0;
  const double change = asked - asked_;
  asked_ = asked;
  if (direction_ * change <= 0.0) direction_ = 0.0;
  if (direction_ == 0.0 && std::abs(asked - stem_) > static_friction) {
    direction_ = asked > stem_ ? 1.0 : -1.0;
  }
  if (direction_ != 0.0) stem_ = asked - direction_ * moving_friction;
  target_ = Characteristic(std::clamp(stem_, options_.min, options_.max));
  return target_;
}

double Actuator::Act(double sample_time) {
  const double most = options_.rate * sample_time;
  acting_ = std::clamp(target_, acting_ - most, acting_ + most);
  return acting_;
}

}  // namespace mle::sim
