#include "control/engineering_variables.h"

#include <algorithm>
#include <cmath>

#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// The least slope of a transform between two values; those of curves are
// monotone, of straight pieces it is at a knot.
double LeastSlope(const Transform& transform, double from, double to) {
  double least = std::min(transform.Slope(from), transform.Slope(to));
  for (const auto& [x, f] : transform.points) {
    if (x > from && x < to) least = std::min(least, transform.Slope(x));
  }
  return least;
}

// The linear values that an input has at all: of a valve from closed to open,
// of other curves those that have an engineering value, but for a thousandth.
struct Bounds {
  double lower = -kInfinity;
  double upper = kInfinity;
};

Bounds BoundsOf(const Transform& transform) {
  constexpr double kInside = 0.999;
  // Of an end of the curve, by how much it is away from a.
  const auto one_end = [&](double distance) -> Bounds {
    const double end = transform.at - kInside * distance;
    if (distance > 0.0) return {end, kInfinity};
    return {-kInfinity, end};
  };
  switch (transform.kind) {
    case TransformKind::kEqualPercentage:
      return {transform.Linear(transform.low),
              transform.Linear(transform.high)};
    case TransformKind::kQuickOpening:
      return {one_end(2.0 * (transform.at - transform.low)).lower,
              transform.Linear(transform.high)};
    case TransformKind::kExponential:
      return one_end(1.0 / transform.curvature);
    case TransformKind::kPower:
      return one_end((transform.at - transform.zero) / transform.exponent);
    default:
      return {};
  }
}

// Limits of an input that has none are those of its curve.
void LimitByCurve(const Bounds& bounds, Index input, Index inputs,
                  MpcLimits& limits) {
  const auto limit = [&](double bound, double none, VectorXd& values) {
    if (!std::isfinite(bound)) return;
    if (values.size() == 0) values = VectorXd::Constant(inputs, none);
    if (!std::isfinite(values[input])) values[input] = bound;
  };
  limit(bounds.lower, -kInfinity, limits.min_input);
  limit(bounds.upper, kInfinity, limits.max_input);
}

template <typename Channels>
absl::Status ChangeLimits(const Channels& channels, const char* field,
                          VectorXd& limits) {
  for (Index i = 0; i < limits.size(); ++i) {
    const auto& channel = channels[i];
    if (!std::isfinite(limits[i]) || channel.transform.IsNone()) continue;
    const double linear = channel.transform.Linear(limits[i]);
    if (!std::isfinite(linear)) {
      return InvalidArgument(
          field, " of ", channel.name, " = ", limits[i], ": its transform (",
          channel.transform.Description(), ") has no value there");
    }
    limits[i] = linear;
  }
  return absl::OkStatus();
}

template <typename Channels>
VectorXd OperatingPoint(const Channels& channels) {
  VectorXd at(static_cast<Index>(channels.size()));
  for (std::size_t i = 0; i < channels.size(); ++i) {
    at[static_cast<Index>(i)] = channels[i].transform.at;
  }
  return at;
}

}  // namespace

EngineeringVariables::EngineeringVariables(const ProcessModel& model) {
  if (!HasTransforms(model)) return;
  for (const InputChannel& input : model.inputs()) {
    inputs_.push_back({input.name, input.transform});
  }
  for (const OutputChannel& output : model.outputs()) {
    outputs_.push_back({output.name, output.transform});
  }
}

absl::StatusOr<MpcLimits> EngineeringVariables::LinearLimits(
    const MpcLimits& limits) const {
  MpcLimits linear = limits;
  if (!has_transforms()) return linear;
  for (Index j = 0; j < limits.max_move.size(); ++j) {
    const Channel& input = inputs_[j];
    if (!std::isfinite(limits.max_move[j]) || input.transform.IsNone()) {
      continue;
    }
    const bool limited = limits.min_input.size() > j &&
                         limits.max_input.size() > j &&
                         std::isfinite(limits.min_input[j]) &&
                         std::isfinite(limits.max_input[j]);
    if (!limited) {
      return InvalidArgument(
          "max_move of ", input.name, " = ", limits.max_move[j],
          ": an input with a transform needs min_input and max_input, too, "
          "between which its moves are limited");
    }
    linear.max_move[j] *=
        LeastSlope(input.transform, limits.min_input[j], limits.max_input[j]);
  }
  MLE_RETURN_IF_ERROR(ChangeLimits(inputs_, "min_input", linear.min_input));
  MLE_RETURN_IF_ERROR(ChangeLimits(inputs_, "max_input", linear.max_input));
  MLE_RETURN_IF_ERROR(ChangeLimits(outputs_, "min_output", linear.min_output));
  MLE_RETURN_IF_ERROR(ChangeLimits(outputs_, "max_output", linear.max_output));
  const auto inputs = static_cast<Index>(inputs_.size());
  for (Index j = 0; j < inputs; ++j) {
    if (inputs_[j].transform.IsNone()) continue;
    LimitByCurve(BoundsOf(inputs_[j].transform), j, inputs, linear);
  }
  return linear;
}

void EngineeringVariables::LinearInputs(Eigen::Ref<VectorXd> inputs) const {
  for (std::size_t j = 0; j < inputs_.size(); ++j) {
    double& x = inputs[static_cast<Index>(j)];
    x = inputs_[j].transform.Linear(x);
  }
}

void EngineeringVariables::LinearOutputs(Eigen::Ref<VectorXd> outputs) const {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    double& x = outputs[static_cast<Index>(i)];
    x = outputs_[i].transform.Linear(x);
  }
}

double EngineeringVariables::LinearInput(int input, double value) const {
  return has_transforms() ? inputs_[input].transform.Linear(value) : value;
}

void EngineeringVariables::Inputs(Eigen::Ref<VectorXd> inputs) const {
  for (std::size_t j = 0; j < inputs_.size(); ++j) {
    double& z = inputs[static_cast<Index>(j)];
    z = inputs_[j].transform.Engineering(z);
  }
}

void EngineeringVariables::Outputs(Eigen::Ref<VectorXd> outputs) const {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    double& z = outputs[static_cast<Index>(i)];
    z = outputs_[i].transform.Engineering(z);
  }
}

VectorXd EngineeringVariables::OperatingInputs() const {
  return OperatingPoint(inputs_);
}

VectorXd EngineeringVariables::OperatingOutputs() const {
  return OperatingPoint(outputs_);
}

}  // namespace mle::control
