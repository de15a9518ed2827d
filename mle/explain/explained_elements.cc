// The elements of an explained output: those of the model and those that may be
// new, with what explanations make of them.

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/status/status.h"
#include "mle/explain/explained_output.h"

namespace mle {
namespace {

using Kind = ExplanationKind;

// The second lag of an element with a lead, of T + L: alone, and beside one
// that is estimated.
constexpr double kLagOfLead = 0.2;
constexpr double kLeastLagOfLead = 0.02;

}  // namespace

// First-order elements of τ for the inputs without one.
void ExplainedOutput::AddNewPaths(const ProcessModel& model) {
  if (integrating_) return;
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (!model.element(output_, j).IsZero()) continue;
    absl::StatusOr<ElementResponse> response =
        ElementResponse::Create(TransferFunction::FirstOrder(1.0, tau_, 0.0));
    if (response.ok()) elements_.push_back({j, *std::move(response), false});
  }
}

const ExplainedOutput::Element* ExplainedOutput::FindElement(int input) const {
  for (const Element& element : elements_) {
    if (element.input == input) return &element;
  }
  return nullptr;
}

const ElementValues& ExplainedOutput::values(int input) const {
  static const ElementValues none;
  const Element* const element = FindElement(input);
  return element == nullptr ? none : element->response.initial_values();
}

bool ExplainedOutput::has_lag(int input) const {
  const Element* const element = FindElement(input);
  return element != nullptr && element->response.has_time_scale();
}

std::vector<int> ExplainedOutput::possible_inputs() const {
  std::vector<int> inputs;
  for (const Element& element : elements_) inputs.push_back(element.input);
  std::sort(inputs.begin(), inputs.end());
  return inputs;
}

std::vector<double> ExplainedOutput::time_constants() const {
  std::vector<double> lags;
  for (const Element& element : elements_) {
    if (element.in_model && element.response.has_time_scale()) {
      lags.push_back(element.response.initial_values().time_scale);
    }
  }
  return lags;
}

std::vector<Explanation> ExplainedOutput::Applicable(
    const std::vector<Explanation>& taken) const {
  std::vector<Explanation> applicable;
  for (const ExplanationType& type : ExplanationTable()) {
    if (type.start.empty()) continue;
    if (type.place == ExplanationPlace::kOutput) {
      // A clock is the one dead time where there is one element.
      if (type.kind == Kind::kOutputClock && inputs_.size() < 2) continue;
      applicable.push_back({type.kind, output_, 0.0});
      continue;
    }
    for (const Element& element : elements_) {
      if (Applies(type.kind, element, taken)) {
        applicable.push_back({type.kind, element.input, 0.0});
      }
    }
  }
  return applicable;
}

bool ExplainedOutput::Applies(ExplanationKind kind, const Element& element,
                              const std::vector<Explanation>& taken) const {
  const int j = element.input;
  if (!(ranges_[j] > 0.0)) return false;
  const auto has = [&](Kind one) {
    bool found = false;
    ValueOf(taken, one, j, &found);
    return found;
  };
  const ElementResponse& response = element.response;
  const bool one_lag = response.has_time_scale() && response.order() == 1 &&
                       !response.is_integrating();
  switch (kind) {
    case Kind::kNewPath:
      return !element.in_model;
    case Kind::kTimeConstant:
      // Of a path that was found its times are estimated, too.
      return response.has_time_scale() &&
             (element.in_model || has(Kind::kNewPath));
    case Kind::kDeadTime:
      return element.in_model || has(Kind::kNewPath);
    case Kind::kHigherOrder:
    case Kind::kLead:
      return element.in_model && one_lag && !has(Kind::kDirection);
    case Kind::kDirection:
      return element.in_model && one_lag && !has(Kind::kHigherOrder) &&
             !has(Kind::kLead);
    case Kind::kLoadWithSetPoints:
      return element.in_model && !moving_set_points_.empty();
    default:
      return element.in_model;
  }
}

std::pair<double, double> ExplainedOutput::Bounds(
    const Explanation& explanation) const {
  const ExplanationType& type = TypeOf(explanation.kind);
  double lower = type.lower;
  if (explanation.kind == Kind::kDeadTime) {
    const ElementValues& values = this->values(explanation.index);
    const double lag = has_lag(explanation.index) ? values.time_scale : 0.0;
    const double scale = std::max(lag + values.delay, sample_time_);
    lower = std::max(lower, -values.delay / scale);
  }
  return {lower, type.upper};
}

ElementValues ExplainedOutput::Before(
    int input, const std::vector<Explanation>& explanations) const {
  ElementValues before = values(input);
  const Element* const element = FindElement(input);
  if (element == nullptr || element->in_model) return before;
  int part = 0;
  const double path =
      ValueOf(explanations, Kind::kNewPath, input, nullptr, &part);
  before.gain = path * output_range_ / std::max(ranges_[input], 1e-300);
  before.time_scale *= std::pow(3.0, part - 1);
  return before;
}

ElementValues ExplainedOutput::Aged(
    int input, const std::vector<Explanation>& explanations) const {
  ElementValues aged = Before(input, explanations);
  const double lag = has_lag(input) ? aged.time_scale : 0.0;
  aged.delay =
      std::max(0.0, aged.delay + ValueOf(explanations, Kind::kDeadTime, input) *
                                     std::max(lag + aged.delay, sample_time_));
  aged.gain *= std::exp(ValueOf(explanations, Kind::kGain, input));
  aged.time_scale *=
      std::exp(ValueOf(explanations, Kind::kTimeConstant, input));
  return aged;
}

ExplainedOutput::Shape ExplainedOutput::ShapeOf(
    const ElementValues& values, int input,
    const std::vector<Explanation>& explanations) {
  const double time = values.time_scale + values.delay;
  Shape shape;
  shape.values = values;
  bool has_lead = false;
  const double lead = ValueOf(explanations, Kind::kLead, input, &has_lead);
  shape.lead = lead * time;
  bool has_second = false;
  const double second =
      ValueOf(explanations, Kind::kHigherOrder, input, &has_second);
  const double least = has_second ? kLeastLagOfLead : kLagOfLead;
  shape.second = time * std::max(second, std::min(std::abs(lead), least));
  // A lead makes up for its own lag.
  if (!has_lead && shape.second > 0.0) {
    shape.values.delay = std::max(values.delay - 0.5 * shape.second, 0.0);
    shape.values.time_scale = std::max(values.time_scale - 0.5 * shape.second,
                                       0.05 * values.time_scale);
  }
  return shape;
}

absl::StatusOr<TransferFunction> ExplainedOutput::Shaped(const Element& element,
                                                         const Shape& shape) {
  const TransferFunction own =
      element.response.ToTransferFunction(shape.values);
  if (shape.second == 0.0 && shape.lead == 0.0) return own;
  if (!own.IsFirstOrder()) {
    return absl::FailedPreconditionError("the element is not of first order");
  }
  const double gain = shape.values.gain;
  const double lag = shape.values.time_scale;
  return TransferFunction({gain * shape.lead, gain},
                          {lag * shape.second, lag + shape.second, 1.0},
                          shape.values.delay);
}

absl::StatusOr<TransferFunction> ExplainedOutput::ElementOf(
    int input, const ElementValues& values,
    const std::vector<Explanation>& explanations) const {
  const Element* const element = FindElement(input);
  if (element == nullptr)
    return absl::NotFoundError("the model has no element of this input");
  return Shaped(*element, ShapeOf(values, input, explanations));
}

}  // namespace mle
