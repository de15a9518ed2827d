#include "sim/ageing.h"

#include <cmath>
#include <set>
#include <utility>

#include "mle/base/status.h"

namespace mle::sim {
namespace {

absl::Status CheckElement(const TransferFunction& element,
                          const ElementAgeing& ageing) {
  if (element.IsZero()) {
    return absl::InvalidArgumentError("is zero in the model; it cannot age");
  }
  if (!(ageing.time_constant.Min() > 0.0)) {
    return InvalidArgument("time_constant falls to ",
                           ageing.time_constant.Min(),
                           "; the factor must stay positive");
  }
  if (!(ageing.falling > 0.0) || !std::isfinite(ageing.falling)) {
    return InvalidArgument("falling = ", ageing.falling,
                           "; the factor must be finite and positive");
  }
  if (element.IsIntegrating() && ageing.falling != 1.0) {
    return InvalidArgument("falling = ", ageing.falling,
                           ", but the element integrates: it must be 1");
  }
  if (!(element.delay() + ageing.delay.Min() >= 0.0)) {
    return InvalidArgument("delay falls by ", -ageing.delay.Min(),
                           ", but the dead time is only ", element.delay(),
                           "; it must not become negative");
  }
  if (!(ageing.delay.MaxSlope() < 1.0)) {
    return InvalidArgument(
        "delay grows by ", ageing.delay.MaxSlope(),
        " per unit of time; a dead time must grow slower than time (< 1). For "
        "a sudden change give two points at one time");
  }
  // An element between the extremes has coefficients between theirs.
  for (const double gain : {ageing.gain.Min(), ageing.gain.Max()}) {
    for (const double time_constant :
         {ageing.time_constant.Min(), ageing.time_constant.Max()}) {
      ElementAgeing extreme;
      extreme.gain = Schedule(gain);
      extreme.time_constant = Schedule(time_constant);
      extreme.delay = Schedule(ageing.delay.Max());
      const absl::Status status =
          AgedElement(element, extreme, /*time=*/0.0).Validate();
      if (!status.ok()) {
        return InvalidArgument("with gain ", gain, ", time_constant ",
                               time_constant, " and delay ", ageing.delay.Max(),
                               ": ", status.message());
      }
    }
  }
  return absl::OkStatus();
}

// The schedule with `map` applied to the value of every point.
template <typename Map>
absl::StatusOr<Schedule> Mapped(const Schedule& schedule, const Map& map) {
  std::vector<Schedule::Point> points = schedule.points();
  for (Schedule::Point& point : points) point.value = map(point.value);
  return Schedule::Create(std::move(points));
}

}  // namespace

absl::Status AgeingSchedule::Validate(const ProcessModel& model) const {
  std::set<std::pair<int, int>> seen;
  for (const ElementAgeing& ageing : elements) {
    if (ageing.output < 0 || ageing.output >= model.num_outputs() ||
        ageing.input < 0 || ageing.input >= model.num_inputs()) {
      return InvalidArgument("ageing of element (", ageing.output, ", ",
                             ageing.input, "): the model has ",
                             model.num_outputs(), " outputs and ",
                             model.num_inputs(), " inputs");
    }
    const absl::Status status =
        seen.insert({ageing.output, ageing.input}).second
            ? CheckElement(model.element(ageing.output, ageing.input), ageing)
            : absl::InvalidArgumentError("is duplicated, must be given once");
    if (!status.ok()) {
      return InvalidArgument(
          "ageing of element (", model.outputs()[ageing.output].name, ", ",
          model.inputs()[ageing.input].name, "): ", status.message());
    }
  }
  return absl::OkStatus();
}

TransferFunction AgedElement(const TransferFunction& element,
                             const ElementAgeing& ageing, double time) {
  const double gain = ageing.gain.At(time);
  const double stretch = ageing.time_constant.At(time);
  // The coefficient of s^i, counted from the end, takes the factor τ^i, of an
  // integrating denominator τ^{i−1}.
  const auto stretched = [stretch](std::vector<double> polynomial,
                                   double factor) {
    for (auto c = polynomial.rbegin(); c != polynomial.rend(); ++c) {
      *c *= factor;
      factor *= stretch;
    }
    return polynomial;
  };
  return TransferFunction(
      stretched(element.numerator(), gain),
      stretched(element.denominator(),
                element.IsIntegrating() ? 1.0 / stretch : 1.0),
      element.delay() + ageing.delay.At(time));
}

ProcessModel AgedModel(const ProcessModel& model, const AgeingSchedule& ageing,
                       double time) {
  ProcessModel aged = model;
  for (const ElementAgeing& one : ageing.elements) {
    aged.element(one.output, one.input) =
        AgedElement(model.element(one.output, one.input), one, time);
  }
  return aged;
}

absl::StatusOr<AgeingSchedule> ScaleAgeing(const AgeingSchedule& ageing,
                                           double rate) {
  if (!std::isfinite(rate) || rate < 0.0) {
    return InvalidArgument("ageing rate = ", rate,
                           ", but it must be finite and not negative");
  }
  AgeingSchedule scaled = ageing;
  for (ElementAgeing& element : scaled.elements) {
    if (!(element.gain.Min() > 0.0)) {
      return InvalidArgument("ageing of element (", element.output, ", ",
                             element.input, "): the gain's factor falls to ",
                             element.gain.Min(),
                             "; it must be positive to be scaled");
    }
    const auto power = [rate](double factor) { return std::pow(factor, rate); };
    MLE_ASSIGN_OR_RETURN(element.gain, Mapped(element.gain, power));
    MLE_ASSIGN_OR_RETURN(element.time_constant,
                         Mapped(element.time_constant, power));
    MLE_ASSIGN_OR_RETURN(
        element.delay,
        Mapped(element.delay, [rate](double delay) { return rate * delay; }));
  }
  return scaled;
}

}  // namespace mle::sim
