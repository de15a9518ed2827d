// How the elements of an explained output respond to the inputs that
// explanations change, and what they leave of the output.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/explain/curves.h"
#include "mle/explain/explained_output.h"
#include "mle/explain/signal_effects.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Kind = ExplanationKind;

}  // namespace

VectorXd ExplainedOutput::LoadOf(int part, int record) const {
  const int moving = num_moving_set_points();
  if (part < moving) return SetPointMoves(part, record);
  VectorXd mean = SetPointMoves(0, record);
  for (int i = 1; i < moving; ++i) mean += SetPointMoves(i, record);
  return mean / static_cast<double>(moving);
}

Eigen::VectorXd ExplainedOutput::InputOf(int input, int record,
                                         const ResponseKey& key) const {
  const auto column = (*filled_)[record].col(input);
  VectorXd v = column.array() - column[0];
  const double range = std::max(ranges_[input], 1e-300);
  if (key.limit != 0.0) {
    const double highest = v.maxCoeff() - key.limit * range;
    const double lowest = v.minCoeff() - key.limit * range;
    for (double& x : v) {
      x = key.limit > 0.0 ? std::min(x, highest) : std::max(x, lowest);
    }
    v.array() -= v[0];
  }
  if (key.slowness > 0.0) {
    const double most = range * sample_time_ / (key.slowness * tau_);
    double x = v[0];
    for (double& value : v) {
      x += std::clamp(value - x, -most, most);
      value = x;
    }
  }
  if (key.backlash > 0.0) {
    const double half = 0.5 * key.backlash * range;
    double x = v[0];
    for (double& value : v) {
      x = std::clamp(x, value - half, value + half);
      value = x;
    }
  }
  if (key.curve != 0.0) {
    // One curve for all records, from where the first began.
    const double begin = column[0] - first_inputs_[input];
    const Explanation curve = {Kind::kCurvedInput, input, key.curve, key.shape};
    const Transform h = CurveTransform(mle::ShapeOf(curve), CurvatureOf(curve),
                                       distances_[input]);
    const double level = h.Linear(begin);
    for (double& x : v) x = h.Linear(begin + x) - level;
  }
  if (key.load != 0.0) {
    v += key.load * range * LoadOf(key.load_part, record);
  }
  return v;
}

std::vector<VectorXd> ExplainedOutput::Simulate(const Element& element,
                                                const ResponseKey& key) const {
  std::vector<VectorXd> responses;
  const ElementResponse* response = &element.response;
  double time_scale = key.time_scale;
  std::optional<ElementResponse> other;
  if (key.second_lag > 0.0) {
    const absl::StatusOr<TransferFunction> shaped =
        Shaped(element, {{1.0, key.time_scale, 0.0}, key.second_lag, key.lead});
    absl::StatusOr<ElementResponse> made =
        shaped.ok() ? ElementResponse::Create(*shaped) : shaped.status();
    if (!made.ok()) {
      for (const Record& record : *records_) {
        responses.push_back(VectorXd::Constant(record.samples(), kNaN));
      }
      return responses;
    }
    other = *std::move(made);
    response = &*other;
    time_scale = other->initial_values().time_scale;
  }
  for (int r = 0; r < static_cast<int>(records_->size()); ++r) {
    const VectorXd v = InputOf(element.input, r, key);
    VectorXd z;
    if (key.falling != 1.0) {
      const double sign =
          element.response.initial_values().gain < 0.0 ? -1.0 : 1.0;
      z = TwoLags(key.time_scale, key.time_scale * key.falling, sample_time_,
                  key.delay, sign, v);
    } else {
      Eigen::MatrixXd column(v.size(), 1);
      response->Simulate(time_scale, sample_time_,
                         SampledDelayOf(key.delay, sample_time_), v, 0.0,
                         column);
      z = column.col(0);
    }
    if (key.delay < 0.0) z = Earlier(z, -key.delay / sample_time_);
    responses.push_back(std::move(z));
  }
  return responses;
}

std::vector<VectorXd> ExplainedOutput::SimulatedBy(
    const std::vector<Element>& elements) const {
  std::vector<VectorXd> z;
  for (const Record& record : *records_) {
    z.push_back(VectorXd::Zero(record.samples()));
  }
  for (const Element& element : elements) {
    if (!element.in_model) continue;
    const ElementValues& values = element.response.initial_values();
    const std::vector<VectorXd> responses = Simulate(
        element, {.time_scale = values.time_scale, .delay = values.delay});
    for (std::size_t r = 0; r < z.size(); ++r) {
      z[r] += values.gain * responses[r];
    }
  }
  return z;
}

std::vector<ResponsePart> ExplainedOutput::Responses(
    const std::vector<Explanation>& explanations) const {
  std::vector<ResponsePart> parts;
  const double clock =
      0.5 * tau_ * ValueOf(explanations, Kind::kOutputClock, output_);
  const double width = ValueOf(explanations, Kind::kAveragedOutput, output_) *
                       tau_ / sample_time_;
  for (int e = 0; e < static_cast<int>(elements_.size()); ++e) {
    const int j = elements_[e].input;
    const ElementValues aged = Aged(j, explanations);
    if (!elements_[e].in_model && aged.gain == 0.0) continue;
    Shape shape = ShapeOf(aged, j, explanations);
    ElementValues& values = shape.values;
    values.delay = std::max(values.delay, 0.0) + clock +
                   0.5 * tau_ * ValueOf(explanations, Kind::kInputClock, j);
    bool reversed = false;
    const double factor = ValueOf(explanations, Kind::kReversed, j, &reversed);
    if (reversed) values.gain *= -std::exp(factor);
    bool limited = false;
    const double rate = ValueOf(explanations, Kind::kRateLimit, j, &limited);
    int part_of_load = 0;
    const double load = ValueOf(explanations, Kind::kLoadWithSetPoints, j,
                                nullptr, &part_of_load);
    int shape_of_curve = 0;
    const double curve =
        ValueOf(explanations, Kind::kCurvedInput, j, nullptr, &shape_of_curve);
    const ResponseKey key = {
        .time_scale = values.time_scale,
        .delay = values.delay,
        .second_lag = shape.second,
        .lead = shape.lead,
        .falling = std::exp(ValueOf(explanations, Kind::kDirection, j)),
        .curve = curve,
        .shape = shape_of_curve,
        .slowness = limited ? std::exp(rate) : 0.0,
        .backlash = ValueOf(explanations, Kind::kBacklash, j),
        .limit = ValueOf(explanations, Kind::kSaturation, j),
        .load = load,
        .load_part = load != 0.0 ? part_of_load : 0,
        .average = width > 1.0 ? width : 0.0};
    parts.push_back({e, key, values.gain});
    int part = 0;
    const double change =
        ValueOf(explanations, Kind::kChangeDuringRecord, j, nullptr, &part);
    if (change == 0.0) continue;
    parts.push_back({e, key, values.gain * change});
    parts.back().key.change = part;
  }
  return parts;
}

VectorXd ExplainedOutput::ResponseOf(const ResponsePart& part) const {
  std::vector<VectorXd> z = Simulate(elements_[part.element], part.key);
  const int change = part.key.change;
  double passed = 0.0;
  for (VectorXd& values : z) {
    if (change >= 0) {
      for (Index k = 0; k < values.size(); ++k) {
        values[k] *= ShareOfChange(
            change, (passed + static_cast<double>(k)) / total_samples_);
      }
    }
    passed += static_cast<double>(values.size());
    if (part.key.average > 1.0) values = Averaged(values, part.key.average);
  }
  return MeasuredMeans(z);
}

bool ExplainedOutput::IsCurved(
    const std::vector<Explanation>& explanations) const {
  return ValueOf(explanations, Kind::kCurvedOutput, output_) != 0.0;
}

VectorXd ExplainedOutput::Residual(
    const std::vector<Explanation>& explanations) const {
  VectorXd z = VectorXd::Zero(measured_.size());
  for (const ResponsePart& part : Responses(explanations)) {
    z += part.gain * cache_.Get(part, [&] { return ResponseOf(part); });
  }
  for (const Explanation& one : explanations) {
    if (one.kind == Kind::kCurvedOutput) BendOutput(one, z);
  }
  return measured_ - z;
}

// y = h(z + δ) − h(δ), δ the mean by which what is measured of a record is
// above z once it is straightened: one sample's noise where a record begins
// counts less, and nothing is added where there is no curve.
void ExplainedOutput::BendOutput(const Explanation& curve, VectorXd& z) const {
  if (curve.value == 0.0) return;
  const Transform h =
      CurveTransform(mle::ShapeOf(curve), CurvatureOf(curve), output_range_);
  std::vector<double> above(records_->size(), 0.0);
  std::vector<int> counts(records_->size(), 0);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const auto k = static_cast<Index>(i);
    const double straight = h.Engineering(measured_[k] - first_level_);
    if (!std::isfinite(straight)) continue;
    above[rows_[i].record] += straight - z[k];
    ++counts[rows_[i].record];
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const int r = rows_[i].record;
    const double at = above[r] / std::max(counts[r], 1);
    double& value = z[static_cast<Index>(i)];
    value = h.Linear(value + at) - h.Linear(at);
  }
}

double ExplainedOutput::CurvatureOf(const Explanation& one) const {
  return one.value / (one.kind == Kind::kCurvedInput
                          ? std::max(distances_[one.index], 1e-300)
                          : output_range_);
}

Explanation ExplainedOutput::InputCurve(const FoundCurve& curve) const {
  return {Kind::kCurvedInput, curve.channel,
          curve.curvature * distances_[curve.channel],
          static_cast<int>(curve.shape)};
}

FoundCurve ExplainedOutput::CurveOf(
    const Explanation& explanation, double standard_error,
    const std::vector<Explanation>& alternatives) const {
  FoundCurve curve;
  curve.is_output = explanation.kind != Kind::kCurvedInput;
  curve.channel = explanation.index;
  curve.shape = mle::ShapeOf(explanation);
  curve.curvature = CurvatureOf(explanation);
  Explanation unit = explanation;
  unit.value = 1.0;
  curve.standard_error = standard_error * CurvatureOf(unit);
  for (const Explanation& one : alternatives) {
    curve.alternatives.push_back({mle::ShapeOf(one), CurvatureOf(one)});
  }
  const int channel = explanation.index;
  curve.at = curve.is_output ? first_level_ : first_inputs_[channel];
  curve.low = kInfinity;
  curve.high = -kInfinity;
  for (const Record& record : *records_) {
    const auto values = curve.is_output ? record.outputs.row(output_)
                                        : record.inputs.row(channel);
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      curve.low = std::min(curve.low, value);
      curve.high = std::max(curve.high, value);
    }
  }
  return curve;
}

absl::StatusOr<VectorXd> ExplainedOutput::ResidualOf(
    const ProcessModel& model) const {
  std::vector<Element> elements;
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.element(output_, j).IsZero()) continue;
    MLE_ASSIGN_OR_RETURN(ElementResponse response,
                         ElementResponse::Create(model.element(output_, j)));
    elements.push_back({j, std::move(response), true});
  }
  return measured_ - MeasuredMeans(SimulatedBy(elements));
}

VectorXd ExplainedOutput::ContributionOf(int input) const {
  const Element& element = *FindElement(input);
  const ElementValues& values = element.response.initial_values();
  return values.gain *
         RowMeans(Simulate(element, {.time_scale = values.time_scale,
                                     .delay = values.delay}));
}

VectorXd ExplainedOutput::LostByAverage(double time) const {
  const double width = time / sample_time_;
  std::vector<VectorXd> lost = SimulatedBy(elements_);
  for (VectorXd& z : lost) {
    if (width > 1.0) z -= Earlier(Averaged(z, width), 0.5 * (width - 1.0));
  }
  return RowMeans(lost);
}

Eigen::MatrixXd ExplainedOutput::DrawStampErrors(double deviation, int draws,
                                                 GaussianNoise& noise) const {
  const std::vector<VectorXd> all = SimulatedBy(elements_);
  std::vector<VectorXd> moved = all;
  Eigen::MatrixXd errors(static_cast<Eigen::Index>(rows_.size()), draws);
  for (int draw = 0; draw < draws; ++draw) {
    for (std::size_t r = 0; r < all.size(); ++r) {
      const VectorXd& z = all[r];
      const auto last = static_cast<double>(z.size() - 1);
      for (Eigen::Index k = 0; k < z.size(); ++k) {
        const double at = std::clamp(
            static_cast<double>(k) + noise.Draw(deviation / sample_time_), 0.0,
            last);
        const auto before = static_cast<Eigen::Index>(at);
        const Eigen::Index after = std::min(before + 1, z.size() - 1);
        moved[r][k] =
            z[before] - z[k] +
            (at - static_cast<double>(before)) * (z[after] - z[before]);
      }
    }
    errors.col(draw) = MeasuredMeans(moved);
  }
  return errors;
}

}  // namespace mle
