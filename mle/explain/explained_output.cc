#include "mle/explain/explained_output.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/explain/signal_effects.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Kind = ExplanationKind;

// Rows of a residual at most, and of τ at least.
constexpr int kMostRows = 1500;
constexpr double kRowsPerTau = 20.0;
// A gap in the inputs longer than this part of τ is not bridged.
constexpr double kBridged = 0.1;
// After a gap the output does not count for this many times the longest T + L.
constexpr double kForgotten = 3.0;
VectorXd FromFirst(const Eigen::RowVectorXd& signal) {
  const VectorXd filled = Filled(signal.transpose());
  return filled.array() - filled[0];
}

}  // namespace

FilledInputs Fill(const std::vector<Record>& records) {
  FilledInputs inputs;
  for (const Record& record : records) {
    Eigen::MatrixXd& filled = inputs.emplace_back(record.inputs.transpose());
    for (Index j = 0; j < filled.cols(); ++j) {
      filled.col(j) = Filled(filled.col(j));
    }
  }
  return inputs;
}

absl::StatusOr<ExplainedOutput> ExplainedOutput::Create(
    const ProcessModel& model, const std::vector<Record>& records, int output,
    std::shared_ptr<const FilledInputs> inputs) {
  ExplainedOutput explained;
  explained.filled_ = inputs != nullptr
                          ? std::move(inputs)
                          : std::make_shared<const FilledInputs>(Fill(records));
  explained.records_ = &records;
  explained.output_ = output;
  explained.sample_time_ = records.front().sample_time;
  std::vector<double> times;
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.element(output, j).IsZero()) continue;
    absl::StatusOr<ElementResponse> response =
        ElementResponse::Create(model.element(output, j));
    if (!response.ok()) {
      return absl::FailedPreconditionError(response.status().message());
    }
    const ElementValues& values = response->initial_values();
    times.push_back(values.delay +
                    (response->has_time_scale() ? values.time_scale : 0.0));
    explained.longest_ = std::max(explained.longest_, times.back());
    explained.integrating_ |= response->is_integrating();
    explained.inputs_.push_back(j);
    explained.elements_.push_back({j, *std::move(response), true});
  }
  if (times.empty()) {
    return absl::FailedPreconditionError("no input reaches the output");
  }
  const auto middle =
      times.begin() + static_cast<std::ptrdiff_t>((times.size() - 1) / 2);
  std::nth_element(times.begin(), middle, times.end());
  explained.tau_ = std::max(*middle, explained.sample_time_);
  explained.longest_ = std::max(explained.longest_, explained.sample_time_);
  explained.AddNewPaths(model);
  explained.ChooseRows();
  explained.FindMovingSetPoints(model.num_outputs());
  if (explained.rows_.empty()) {
    return absl::FailedPreconditionError("no sample is measured");
  }
  explained.cache_ = ResponseCache(static_cast<double>(explained.rows_.size()));
  explained.measured_ = explained.MeasuredMeans(explained.outputs_);
  const std::vector<VectorXd> z = explained.SimulatedBy(explained.elements_);
  double low = 0.0;
  double high = 0.0;
  for (const VectorXd& values : z) {
    if (!values.allFinite()) {
      return absl::FailedPreconditionError("its response is not finite");
    }
    low = std::min(low, values.minCoeff());
    high = std::max(high, values.maxCoeff());
  }
  explained.output_range_ = high > low ? high - low : 1.0;
  return explained;
}

void ExplainedOutput::ChooseRows() {
  total_samples_ = 0.0;
  for (const Record& record : *records_) total_samples_ += record.samples();
  const double most = std::floor(tau_ / (kRowsPerTau * sample_time_));
  samples_a_row_ = static_cast<int>(std::clamp(
      std::floor(total_samples_ / kMostRows), 1.0, std::max(most, 1.0)));
  const Index m = records_->front().num_inputs();
  VectorXd low = VectorXd::Constant(m, 1e300);
  VectorXd high = VectorXd::Constant(m, -1e300);
  distances_ = VectorXd::Zero(m);
  for (int r = 0; r < static_cast<int>(records_->size()); ++r) {
    const Record& record = (*records_)[r];
    const Eigen::MatrixXd& filled = (*filled_)[r];
    outputs_.emplace_back(record.outputs.row(output_).transpose());
    std::vector<bool> counts(record.samples(), true);
    const double longest_gap = std::max(3.0, kBridged * tau_ / sample_time_);
    const double forgotten = kForgotten * longest_ / sample_time_;
    for (const Element& element : elements_) {
      const int j = element.input;
      double gap = 0.0;
      double uncertain = 0.0;
      for (Index k = 0; k < filled.rows(); ++k) {
        if (std::isfinite(record.inputs(j, k))) {
          if (gap > longest_gap) uncertain = forgotten;
          gap = 0.0;
        } else {
          gap += 1.0;
        }
        if (element.in_model && (gap > longest_gap || uncertain > 0.0)) {
          counts[k] = false;
        }
        uncertain -= 1.0;
      }
      low[j] = std::min(low[j], filled.col(j).minCoeff());
      high[j] = std::max(high[j], filled.col(j).maxCoeff());
      distances_[j] =
          std::max(distances_[j],
                   (filled.col(j).array() - filled(0, j)).abs().maxCoeff());
    }
    for (int first = 0; first + samples_a_row_ <= record.samples();
         first += samples_a_row_) {
      bool measured = false;
      bool known = true;
      for (int k = first; k < first + samples_a_row_; ++k) {
        measured = measured || std::isfinite(outputs_.back()[k]);
        known = known && counts[k];
      }
      if (measured && known) rows_.push_back({r, first, samples_a_row_});
    }
  }
  ranges_ = (high - low).cwiseMax(0.0);
}

void ExplainedOutput::FindMovingSetPoints(int set_points) {
  for (const Record& record : *records_) {
    if (record.set_points.rows() == 0) return;
  }
  for (int i = 0; i < set_points; ++i) {
    double range = 0.0;
    for (const Record& record : *records_) {
      const VectorXd moves = FromFirst(record.set_points.row(i));
      range = std::max(range, moves.maxCoeff() - moves.minCoeff());
    }
    if (range > 0.0) moving_set_points_.push_back({i, range});
  }
}

VectorXd ExplainedOutput::SetPointMoves(int which, int record) const {
  const MovingSetPoint& set_point = moving_set_points_[which];
  return FromFirst((*records_)[record].set_points.row(set_point.number)) /
         set_point.range;
}

VectorXd ExplainedOutput::LoadOf(int part, int record) const {
  const int moving = num_moving_set_points();
  if (part < moving) return SetPointMoves(part, record);
  VectorXd mean = SetPointMoves(0, record);
  for (int i = 1; i < moving; ++i) mean += SetPointMoves(i, record);
  return mean / static_cast<double>(moving);
}

int ExplainedOutput::PartsOf(ExplanationKind kind) const {
  switch (kind) {
    case Kind::kChangeDuringRecord:
      return kParts;
    case Kind::kNewPath:
      return kPathLags;
    case Kind::kLoadWithSetPoints: {
      const int moving = num_moving_set_points();
      return moving < 2 ? moving : moving + 1;
    }
    default:
      return 1;
  }
}

Eigen::VectorXd ExplainedOutput::InputOf(int input, int record,
                                         const ResponseKey& key) const {
  const auto column = (*filled_)[record].col(input);
  VectorXd v = column.array() - column[0];
  const double range = std::max(ranges_[input], 1e-300);
  const double curve = key[5];
  const double slowness = key[6];
  const double play = key[7];
  const double limit = key[8];
  const double load = key[9];
  if (limit != 0.0) {
    const double highest = v.maxCoeff() - limit * range;
    const double lowest = v.minCoeff() - limit * range;
    for (double& x : v) {
      x = limit > 0.0 ? std::min(x, highest) : std::max(x, lowest);
    }
    v.array() -= v[0];
  }
  if (slowness > 0.0) {
    const double most = range * sample_time_ / (slowness * tau_);
    double x = v[0];
    for (double& value : v) {
      x += std::clamp(value - x, -most, most);
      value = x;
    }
  }
  if (play > 0.0) {
    const double half = 0.5 * play * range;
    double x = v[0];
    for (double& value : v) {
      x = std::clamp(x, value - half, value + half);
      value = x;
    }
  }
  if (curve != 0.0) {
    const double distance = std::max(distances_[input], 1e-300);
    v.array() += curve * v.array().square() / distance;
  }
  if (load != 0.0) {
    v += load * range * LoadOf(static_cast<int>(key[10]), record);
  }
  return v;
}

std::vector<VectorXd> ExplainedOutput::Simulate(const Element& element,
                                                const ResponseKey& key) const {
  const auto [lag, delay, second, lead, falling] =
      std::array<double, 5>{key[0], key[1], key[2], key[3], key[4]};
  std::vector<VectorXd> responses;
  const ElementResponse* response = &element.response;
  double time_scale = lag;
  std::optional<ElementResponse> other;
  if (second > 0.0) {
    const absl::StatusOr<TransferFunction> shaped =
        Shaped(element, {{1.0, lag, 0.0}, second, lead});
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
    if (falling != 1.0) {
      const double sign =
          element.response.initial_values().gain < 0.0 ? -1.0 : 1.0;
      z = TwoLags(lag, lag * falling, sample_time_, delay, sign, v);
    } else {
      Eigen::MatrixXd column(v.size(), 1);
      response->Simulate(time_scale, sample_time_,
                         SampledDelayOf(delay, sample_time_), v, 0.0, column);
      z = column.col(0);
    }
    if (delay < 0.0) z = Earlier(z, -delay / sample_time_);
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
    const std::vector<VectorXd> responses =
        Simulate(element, {values.time_scale, values.delay, 0.0, 0.0, 1.0});
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
    const double falling = std::exp(ValueOf(explanations, Kind::kDirection, j));
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
    const ResponseKey key = {values.time_scale,
                             values.delay,
                             shape.second,
                             shape.lead,
                             falling,
                             ValueOf(explanations, Kind::kCurvedInput, j),
                             limited ? std::exp(rate) : 0.0,
                             ValueOf(explanations, Kind::kBacklash, j),
                             ValueOf(explanations, Kind::kSaturation, j),
                             load,
                             load != 0.0 ? part_of_load : 0.0,
                             width > 1.0 ? width : 0.0};
    parts.push_back({e, key, values.gain});
    int part = 0;
    const double change =
        ValueOf(explanations, Kind::kChangeDuringRecord, j, nullptr, &part);
    if (change == 0.0) continue;
    parts.push_back({e, key, values.gain * change});
    parts.back().key.back() = part + 1.0;
  }
  return parts;
}

VectorXd ExplainedOutput::ResponseOf(const ResponsePart& part) const {
  std::vector<VectorXd> z = Simulate(elements_[part.element], part.key);
  const double width = part.key[11];
  const int change = static_cast<int>(part.key[12]) - 1;
  double passed = 0.0;
  for (VectorXd& values : z) {
    if (change >= 0) {
      for (Index k = 0; k < values.size(); ++k) {
        values[k] *= ShareOfChange(
            change, (passed + static_cast<double>(k)) / total_samples_);
      }
    }
    passed += static_cast<double>(values.size());
    if (width > 1.0) values = Averaged(values, width);
  }
  return MeasuredMeans(z);
}

bool ExplainedOutput::IsCurved(
    const std::vector<Explanation>& explanations) const {
  return ValueOf(explanations, Kind::kCurvedOutput, output_) != 0.0 ||
         ValueOf(explanations, Kind::kSShapedOutput, output_) != 0.0;
}

VectorXd ExplainedOutput::Residual(
    const std::vector<Explanation>& explanations) const {
  VectorXd z = VectorXd::Zero(measured_.size());
  for (const ResponsePart& part : Responses(explanations)) {
    z += part.gain * cache_.Get(part, [&] { return ResponseOf(part); });
  }
  if (IsCurved(explanations)) {
    const double curve = ValueOf(explanations, Kind::kCurvedOutput, output_);
    const double cubic = ValueOf(explanations, Kind::kSShapedOutput, output_);
    const Eigen::ArrayXd scaled = z.array() / output_range_;
    z.array() +=
        output_range_ * (curve * scaled.square() + cubic * scaled.cube());
  }
  return measured_ - z;
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

VectorXd ExplainedOutput::MeasuredMeans(const std::vector<VectorXd>& z) const {
  VectorXd means(static_cast<Index>(rows_.size()));
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const ResidualRow& row = rows_[i];
    const VectorXd& y = outputs_[row.record];
    const VectorXd& values = z[row.record];
    double sum = 0.0;
    int count = 0;
    for (int k = row.first; k < row.first + row.samples; ++k) {
      if (!std::isfinite(y[k])) continue;
      sum += values[k];
      ++count;
    }
    means[static_cast<Index>(i)] = sum / count;
  }
  return means;
}

VectorXd ExplainedOutput::ContributionOf(int input) const {
  const Element& element = *FindElement(input);
  const ElementValues& values = element.response.initial_values();
  return values.gain *
         RowMeans(Simulate(element,
                           {values.time_scale, values.delay, 0.0, 0.0, 1.0}));
}

VectorXd ExplainedOutput::LostByAverage(double time) const {
  const double width = time / sample_time_;
  std::vector<VectorXd> lost = SimulatedBy(elements_);
  for (VectorXd& z : lost) {
    if (width > 1.0) z -= Earlier(Averaged(z, width), 0.5 * (width - 1.0));
  }
  return RowMeans(lost);
}

VectorXd ExplainedOutput::InputRows(int input) const {
  std::vector<VectorXd> signal;
  for (const Eigen::MatrixXd& inputs : *filled_) {
    signal.push_back(inputs.col(input));
  }
  return RowMeans(signal);
}

VectorXd ExplainedOutput::RowMeans(const std::vector<VectorXd>& signal) const {
  VectorXd means(static_cast<Index>(rows_.size()));
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const ResidualRow& row = rows_[i];
    means[static_cast<Index>(i)] =
        signal[row.record].segment(row.first, row.samples).mean();
  }
  return means;
}

}  // namespace mle
