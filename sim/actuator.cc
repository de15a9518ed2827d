#include "sim/actuator.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {

absl::Status ActuatorOptions::Validate(const ProcessModel& channels) const {
  if (input < 0 || input >= channels.num_inputs()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "actuator: input = ", input, ", but it must be one of 0 … ",
        channels.num_inputs() - 1));
  }
  const InputChannel& channel = channels.inputs()[input];
  if (channel.role == InputRole::kDisturbance) {
    return absl::InvalidArgumentError(
        absl::StrCat("actuator of '", channel.name,
                     "': the input is a disturbance, which has no actuator"));
  }
  MLE_RETURN_IF_ERROR(CheckNotNegative("stiction", stiction));
  MLE_RETURN_IF_ERROR(CheckNotNegative("jump", slip_jump));
  MLE_RETURN_IF_ERROR(CheckPositive("span", span));
  MLE_RETURN_IF_ERROR(CheckProbability("position", position));
  if (rangeability >= 1.0 && std::isfinite(rangeability)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "rangeability = ", rangeability, ", but it must be finite and ≥ 1"));
}

double Actuator::Characteristic(double stem) const {
  const double range = std::log(options_.rangeability);
  if (range == 0.0) return stem;
  const double part = std::clamp(stem / options_.span, -options_.position,
                                 1.0 - options_.position);
  return options_.span * std::expm1(range * part) / range;
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
  return Characteristic(stem_);
}

}  // namespace mle::sim
