#include "mle/explain/explained_output.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "absl/status/status.h"

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
  explained.FindFirstValues();
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
                   (filled.col(j).array() - first_inputs_[j]).abs().maxCoeff());
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

// Of the output the median of what is measured first, for τ/4 or five samples.
void ExplainedOutput::FindFirstValues() {
  const auto most = std::max<std::size_t>(
      5, static_cast<std::size_t>(0.25 * tau_ / sample_time_));
  std::vector<double> first;
  for (const double value : records_->front().outputs.row(output_)) {
    if (first.size() == most) break;
    if (std::isfinite(value)) first.push_back(value);
  }
  if (!first.empty()) {
    const auto middle =
        first.begin() + static_cast<std::ptrdiff_t>(first.size() / 2);
    std::nth_element(first.begin(), middle, first.end());
    first_level_ = *middle;
  }
  first_inputs_ = filled_->front().row(0);
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

std::vector<int> ExplainedOutput::PartsOf(ExplanationKind kind) const {
  int parts = 1;
  if (kind == Kind::kChangeDuringRecord) parts = kParts;
  if (kind == Kind::kNewPath) parts = kPathLags;
  if (kind == Kind::kLoadWithSetPoints) {
    const int moving = num_moving_set_points();
    parts = moving < 2 ? moving : moving + 1;
  }
  if (IsCurve(kind)) return CompetingShapes(kind);
  std::vector<int> all(static_cast<std::size_t>(parts));
  std::iota(all.begin(), all.end(), 0);
  return all;
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
