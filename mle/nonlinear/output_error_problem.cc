#include "mle/nonlinear/output_error_problem.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "glog/logging.h"
#include "mle/nonlinear/amplitude_fit.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

void OutputPoint::SetCells(double sample_time) {
  cells.resize(values.size());
  for (std::size_t j = 0; j < values.size(); ++j) {
    cells[j] = static_cast<int>(values[j].delay / sample_time);
  }
}

std::vector<int> FreeParameters(const std::vector<bool>& free) {
  std::vector<int> parameters;
  for (int j = 0; j < std::ssize(free); ++j) {
    for (int i = 0; free[j] && i < 3; ++i) parameters.push_back(3 * j + i);
  }
  return parameters;
}

std::vector<int> LagRanges(int longest) {
  std::vector<int> first_lags = {1};
  while (first_lags.back() <= longest) {
    first_lags.push_back(2 * first_lags.back());
  }
  return first_lags;
}

OutputErrorProblem::OutputErrorProblem(Elements elements,
                                       const std::vector<Record>& records,
                                       int output, int skip, int min_rows)
    : elements_(std::move(elements)) {
  for (const auto& element : elements_) {
    if (!element.has_value()) continue;
    num_modes_ += element->order();
    integrating_ = integrating_ || element->is_integrating();
  }
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Record& record = records[r];
    sample_time_ = record.sample_time;
    const auto inputs_known = [&](int k) {
      for (int j = 0; j < num_elements(); ++j) {
        if (elements_[j].has_value() && !std::isfinite(record.inputs(j, k))) {
          return false;
        }
      }
      return true;
    };
    for (int begin = 0; begin < record.samples();) {
      int end = begin;
      while (end < record.samples() && inputs_known(end)) ++end;
      Segment segment;
      segment.record = static_cast<int>(r);
      segment.start_time = record.start_time + begin * record.sample_time;
      for (int k = begin + skip; k < end; ++k) {
        if (std::isfinite(record.outputs(output, k))) {
          segment.times.push_back(k - begin);
        }
      }
      const int rows = static_cast<int>(segment.times.size());
      if (rows >= std::max(min_rows, num_modes_ + 2 + (integrating_ ? 1 : 0))) {
        segment.inputs =
            record.inputs.middleCols(begin, end - begin).transpose();
        segment.outputs.resize(rows);
        for (int row = 0; row < rows; ++row) {
          segment.outputs(row) =
              record.outputs(output, begin + segment.times[row]);
        }
        num_samples_ += rows;
        total_squares_ +=
            (segment.outputs.array() - segment.outputs.mean()).square().sum();
        segments_.push_back(std::move(segment));
      }
      begin = end + 1;
    }
  }
}

int OutputErrorProblem::shortest_segment() const {
  int shortest = segments_.empty() ? 0 : num_samples_;
  for (const Segment& segment : segments_) {
    shortest = std::min(shortest, static_cast<int>(segment.times.size()));
  }
  return shortest;
}

std::vector<int> OutputErrorProblem::FreeParameters(
    const std::vector<bool>& free) const {
  std::vector<int> parameters;
  for (int j = 0; j < num_elements(); ++j) {
    if (!free[j]) continue;
    for (int i = 0; i < 3; ++i) {
      const bool without =
          i == 1 && elements_[j].has_value() && !elements_[j]->has_time_scale();
      if (!without) parameters.push_back(3 * j + i);
    }
  }
  return parameters;
}

std::vector<int> OutputErrorProblem::FreeColumns(
    const std::vector<bool>& free) const {
  const std::vector<int> all = mle::FreeParameters(free);
  std::vector<int> columns;
  for (const int parameter : FreeParameters(free)) {
    columns.push_back(static_cast<int>(
        std::find(all.begin(), all.end(), parameter) - all.begin()));
  }
  return columns;
}

bool OutputErrorProblem::IsExcited(int input) const {
  for (const Segment& segment : segments_) {
    const auto column = segment.inputs.col(input);
    const double size = column.cwiseAbs().maxCoeff();
    if (column.maxCoeff() - column.minCoeff() > 1e-9 * size) return true;
  }
  return false;
}

Eigen::Index OutputErrorProblem::FreeResponses(const Segment& segment,
                                               const OutputPoint& point, int j,
                                               MatrixXd& columns,
                                               MatrixXd& derivatives) const {
  const std::vector<int>& times = segment.times;
  elements_[j]->FreeResponses(point.values[j].time_scale, sample_time_,
                              times.back() - times.front() + 1, columns,
                              derivatives);
  return std::lower_bound(times.begin(), times.end(),
                          times.front() + columns.rows()) -
         times.begin();
}

Eigen::Index OutputErrorProblem::Modes(const Segment& segment,
                                       const OutputPoint& point, int j,
                                       Eigen::Ref<MatrixXd> columns,
                                       Eigen::Ref<MatrixXd> derivatives) const {
  if (columns.cols() == 0) return 0;
  MatrixXd modes;
  MatrixXd by_time_scale;
  const Eigen::Index kept =
      FreeResponses(segment, point, j, modes, by_time_scale);
  // Samples without a gap between them are copied together.
  const std::vector<int>& times = segment.times;
  const Eigen::Index zeros = columns.rows() - kept;
  columns.bottomRows(zeros).setZero();
  derivatives.bottomRows(zeros).setZero();
  for (Eigen::Index row = 0; row < kept;) {
    Eigen::Index end = row + 1;
    while (end < kept && times[end] == times[end - 1] + 1) ++end;
    const int k = times[row] - times.front();
    columns.middleRows(row, end - row) = modes.middleRows(k, end - row);
    derivatives.middleRows(row, end - row) =
        by_time_scale.middleRows(k, end - row);
    row = end;
  }
  return kept;
}

void OutputErrorProblem::Amplitudes(int s, const OutputPoint& point,
                                    MatrixXd& columns,
                                    MatrixXd& derivatives) const {
  const Segment& segment = segments_[s];
  columns.resize(segment.outputs.size(), num_modes_);
  derivatives.resize(segment.outputs.size(), num_modes_);
  Eigen::Index mode = 0;
  for (int j = 0; j < num_elements(); ++j) {
    if (!elements_[j].has_value()) continue;
    const int r = elements_[j]->order();
    Modes(segment, point, j, columns.middleCols(mode, r),
          derivatives.middleCols(mode, r));
    mode += r;
  }
  AppendDisturbances(s, columns);
}

ElementRun OutputErrorProblem::Run(const Segment& segment,
                                   const OutputPoint& point, int j,
                                   bool derivatives) const {
  const ElementValues& values = point.values[j];
  const double fraction =
      std::clamp(values.delay / sample_time_ - point.cells[j], 0.0, 1.0);
  return elements_[j]->Run(values.time_scale, sample_time_,
                           {point.cells[j], fraction}, segment.inputs.col(j),
                           segment.inputs(0, j), derivatives);
}

void OutputErrorProblem::Respond(const Segment& segment,
                                 const OutputPoint& point, int j,
                                 MatrixXd& response, bool derivatives) const {
  response.resize(segment.inputs.rows(), derivatives ? 3 : 1);
  Run(segment, point, j, derivatives).Next(response);
}

std::vector<SegmentColumns> OutputErrorProblem::Linearise(
    const OutputPoint& point, const NoiseShape& shape,
    const std::vector<bool>& free) const {
  const auto is_free = [&](int j) { return !free.empty() && free[j]; };
  const auto width = 3 * std::count(free.begin(), free.end(), true);
  std::vector<SegmentColumns> all(segments_.size());
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const Segment& segment = segments_[s];
    SegmentColumns& columns = all[s];
    const Eigen::Index rows = segment.outputs.size();
    columns.residuals = segment.outputs;
    columns.jacobian.setZero(rows, width);
    MatrixXd response;
    Eigen::Index parameter = 0;
    for (int j = 0; j < num_elements(); ++j) {
      if (elements_[j].has_value()) {
        const double gain = point.values[j].gain;
        Respond(segment, point, j, response, is_free(j));
        for (Eigen::Index row = 0; row < rows; ++row) {
          const auto at = response.row(segment.times[row]);
          columns.residuals(row) -= gain * at(0);
          if (!is_free(j)) continue;
          columns.jacobian(row, parameter) = -at(0);
          columns.jacobian(row, parameter + 1) = -gain * at(1);
          columns.jacobian(row, parameter + 2) = -gain * at(2);
        }
      }
      if (is_free(j)) parameter += 3;
    }
    MatrixXd derivatives;
    Amplitudes(static_cast<int>(s), point, columns.amplitudes, derivatives);
    if (width == 0 || num_modes_ == 0) continue;

    // The modes' part of the derivative by ln T takes their amplitudes.
    const VectorXd amplitudes =
        AmplitudesOf(static_cast<int>(s), columns, shape);
    Eigen::Index mode = 0;
    Eigen::Index by_time_scale = 1;
    for (int j = 0; j < num_elements(); ++j) {
      if (elements_[j].has_value()) {
        const int r = elements_[j]->order();
        if (is_free(j)) {
          columns.jacobian.col(by_time_scale) -=
              derivatives.middleCols(mode, r) * amplitudes.segment(mode, r);
        }
        mode += r;
      }
      if (is_free(j)) by_time_scale += 3;
    }
  }
  return all;
}

WhitenedColumns OutputErrorProblem::WhitenSegment(
    int s, const SegmentColumns& columns, const NoiseShape& shape) const {
  const Eigen::Index width = columns.jacobian.cols();
  const Eigen::Index free = columns.amplitudes.cols();
  MatrixXd whitened(columns.residuals.size(), 1 + width + free);
  whitened.col(0) = columns.residuals;
  if (width > 0) whitened.middleCols(1, width) = columns.jacobian;
  whitened.rightCols(free) = columns.amplitudes;
  const InnovationsFilter filter(segments_[s].times, shape,
                                 segments_[s].weights);
  filter.Apply(whitened);
  WhitenedColumns result;
  result.log_determinant = filter.log_determinant();
  const AmplitudeFit amplitudes(whitened.rightCols(free));
  amplitudes.TakeOut(whitened.leftCols(1 + width));
  // The modes' own sizes count: they depend on the ratio.
  result.log_amplitudes = amplitudes.LogDeterminant();
  result.num_amplitudes = static_cast<int>(amplitudes.rank());
  result.residuals = whitened.col(0);
  result.jacobian = whitened.middleCols(1, width);
  return result;
}

WhitenedColumns OutputErrorProblem::Whiten(
    const std::vector<SegmentColumns>& columns, const NoiseShape& shape) const {
  WhitenedColumns result;
  result.residuals.resize(num_samples_);
  result.jacobian.resize(num_samples_,
                         columns.empty() ? 0 : columns.front().jacobian.cols());
  Eigen::Index begin = 0;
  for (int s = 0; s < num_segments(); ++s) {
    const WhitenedColumns of = WhitenSegment(s, columns[s], shape);
    const Eigen::Index rows = of.residuals.size();
    result.residuals.segment(begin, rows) = of.residuals;
    if (of.jacobian.cols() > 0) {
      result.jacobian.middleRows(begin, rows) = of.jacobian;
    }
    result.log_determinant += of.log_determinant;
    result.log_amplitudes += of.log_amplitudes;
    result.num_amplitudes += of.num_amplitudes;
    begin += rows;
  }
  return result;
}

void OutputErrorProblem::SetLines(const std::vector<double>& periods) {
  lines_ = periods;
  if (at_rest_ != nullptr) at_rest_->SetLines(periods);
}

void OutputErrorProblem::SetAtRest(
    std::unique_ptr<OutputErrorProblem> problem) {
  at_rest_ = std::move(problem);
  if (at_rest_ != nullptr) at_rest_->SetLines(lines_);
}

void OutputErrorProblem::SetWeights(const VectorXd& weights,
                                    double variance_factor) {
  const bool any = weights.size() > 0;
  CHECK(!any || weights.size() == num_samples_);
  CHECK(!any || weights.minCoeff() > 0.0);
  weights_ = weights;
  variance_factor_ = variance_factor;
  Eigen::Index begin = 0;
  for (Segment& segment : segments_) {
    const Eigen::Index rows = segment.outputs.size();
    segment.weights = any ? VectorXd(weights.segment(begin, rows)) : VectorXd();
    begin += rows;
  }
}

void OutputErrorProblem::SetStampNoise(const VectorXd& weights,
                                       double deviation) {
  stamp_weights_ = weights;
  stamp_deviation_ = deviation;
  SetWeights(weights, 1.0);
}

VectorXd OutputErrorProblem::WhiteResiduals(const OutputPoint& point,
                                            const NoiseShape& shape) const {
  return WhiteResiduals(Linearise(point, shape, {}), shape);
}

VectorXd OutputErrorProblem::WhiteResiduals(
    const std::vector<SegmentColumns>& columns, const NoiseShape& shape) const {
  VectorXd all(num_samples_);
  Eigen::Index begin = 0;
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const Segment& segment = segments_[s];
    const InnovationsFilter filter(segment.times, shape, segment.weights);
    VectorXd residuals = columns[s].residuals;
    if (columns[s].amplitudes.cols() > 0) {
      residuals -= columns[s].amplitudes *
                   AmplitudesOf(static_cast<int>(s), columns[s], shape);
    }
    all.segment(begin, residuals.size()) = filter.WhitePart(residuals);
    begin += residuals.size();
  }
  return all;
}

VectorXd OutputErrorProblem::AmplitudesOf(int segment,
                                          const SegmentColumns& columns,
                                          const NoiseShape& shape) const {
  const Eigen::Index free = columns.amplitudes.cols();
  MatrixXd whitened(columns.residuals.size(), 1 + free);
  whitened << columns.residuals, columns.amplitudes;
  InnovationsFilter(segments_[segment].times, shape, segments_[segment].weights)
      .Apply(whitened);
  return AmplitudeFit(whitened.rightCols(free)).Solve(whitened.col(0));
}

std::vector<MatrixXd> OutputErrorProblem::LagSums(
    const std::vector<int>& first_lags) const {
  const Eigen::Index ranges = static_cast<Eigen::Index>(first_lags.size()) - 1;
  std::vector<MatrixXd> all;
  for (const Segment& segment : segments_) {
    const Eigen::Index rows = segment.outputs.size();
    MatrixXd& sums =
        all.emplace_back(MatrixXd::Zero(rows, num_elements() * ranges));
    for (int j = 0; j < num_elements(); ++j) {
      const auto input = segment.inputs.col(j);
      if (!input.allFinite()) continue;
      // Σ_{i<k} (u_i − u_0): sums over lags are differences of it.
      VectorXd sum(input.size() + 1);
      sum(0) = 0.0;
      for (Eigen::Index k = 0; k < input.size(); ++k) {
        sum(k + 1) = sum(k) + input(k) - input(0);
      }
      for (Eigen::Index row = 0; row < rows; ++row) {
        const int k = segment.times[row];
        for (Eigen::Index b = 0; b < ranges; ++b) {
          sums(row, j * ranges + b) =
              sum(std::max(k - first_lags[b] + 1, 0)) -
              sum(std::max(k - first_lags[b + 1] + 1, 0));
        }
      }
    }
  }
  return all;
}

MatrixXd OutputErrorProblem::Dictionary(
    const OutputPoint& point, const NoiseShape& shape,
    const std::vector<std::vector<int>>& delays) const {
  Eigen::Index width = 1;
  for (const std::vector<int>& of_element : delays) width += of_element.size();
  MatrixXd dictionary(num_samples_, width);
  Eigen::Index begin = 0;
  for (int s = 0; s < num_segments(); ++s) {
    const Segment& segment = segments_[s];
    const Eigen::Index rows = segment.outputs.size();
    MatrixXd columns(rows, width);
    columns.col(width - 1) = segment.outputs;
    Eigen::Index column = 0;
    MatrixXd response(segment.inputs.rows(), 3);
    for (int j = 0; j < num_elements(); ++j) {
      if (!elements_[j].has_value()) continue;
      if (delays[j].empty()) {
        Respond(segment, point, j, response);
        for (Eigen::Index row = 0; row < rows; ++row) {
          columns(row, width - 1) -=
              point.values[j].gain * response(segment.times[row], 0);
        }
        continue;
      }
      elements_[j]->Simulate(point.values[j].time_scale, sample_time_, {0, 0.0},
                             segment.inputs.col(j), segment.inputs(0, j),
                             response);
      for (const int delay : delays[j]) {
        for (Eigen::Index row = 0; row < rows; ++row) {
          const int k = std::max(segment.times[row] - delay, 0);
          columns(row, column) = response(k, 0);
        }
        ++column;
      }
    }
    const InnovationsFilter filter(segment.times, shape, segment.weights);
    filter.Apply(columns);
    MatrixXd amplitudes;
    MatrixXd derivatives;
    Amplitudes(s, point, amplitudes, derivatives);
    filter.Apply(amplitudes);
    AmplitudeFit(amplitudes).TakeOut(columns);
    dictionary.middleRows(begin, rows) = columns;
    begin += rows;
  }
  return dictionary;
}

}  // namespace mle
