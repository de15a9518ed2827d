#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void AppendLine(const std::vector<int>& times, double period,
                MatrixXd& columns) {
  const Eigen::Index width = columns.cols();
  const auto rows = static_cast<Eigen::Index>(times.size());
  columns.conservativeResize(rows, width + 2);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double angle = 2.0 * M_PI * times[row] / period;
    columns(row, width) = std::cos(angle);
    columns(row, width + 1) = std::sin(angle);
  }
}

double LevelStep::At(double when, double sample_time) const {
  const double samples = (when - time) / sample_time;
  if (samples < -0.5) return 0.0;
  return lag > 0.0 ? -size * std::expm1(-(samples + 1.0) * sample_time / lag)
                   : size;
}

void AppendStep(const std::vector<int>& times, const SegmentStep& step,
                MatrixXd& columns) {
  const LevelStep unit = {
      .time = static_cast<double>(step.sample), .lag = step.lag, .size = 1.0};
  const Eigen::Index width = columns.cols();
  const auto rows = static_cast<Eigen::Index>(times.size());
  columns.conservativeResize(rows, width + 1);
  for (Eigen::Index row = 0; row < rows; ++row) {
    columns(row, width) = unit.At(times[row], 1.0);
  }
}

void AppendRamp(const std::vector<int>& times, MatrixXd& columns) {
  const Eigen::Index width = columns.cols();
  const auto rows = static_cast<Eigen::Index>(times.size());
  columns.conservativeResize(rows, width + 1);
  const double length = std::max(times.back() - times.front(), 1);
  for (Eigen::Index row = 0; row < rows; ++row) {
    columns(row, width) = (times[row] - times.front()) / length;
  }
}

void OutputErrorProblem::AppendDisturbances(int segment,
                                            MatrixXd& columns) const {
  for (const double period : lines_) {
    AppendLine(segments_[segment].times, period, columns);
  }
  for (const SegmentStep& step : steps_) {
    if (step.segment == segment) {
      AppendStep(segments_[segment].times, step, columns);
    }
  }
  if (integrating_) AppendRamp(segments_[segment].times, columns);
}

OutputErrorProblem::Sizes OutputErrorProblem::DisturbanceSizes(
    const OutputPoint& point, const NoiseShape& shape) const {
  const auto num_lines = static_cast<Eigen::Index>(lines_.size());
  VectorXd squares = VectorXd::Zero(num_lines);
  Sizes sizes;
  sizes.steps.assign(steps_.size(), 0.0);
  if (lines_.empty() && steps_.empty()) return sizes;
  const std::vector<SegmentColumns> columns = Linearise(point, shape, {});
  for (int s = 0; s < num_segments(); ++s) {
    const VectorXd amplitudes = AmplitudesOf(s, columns[s], shape);
    for (Eigen::Index line = 0; line < num_lines; ++line) {
      squares(line) +=
          amplitudes.segment(num_modes_ + 2 * line, 2).squaredNorm();
    }
    Eigen::Index place = num_modes_ + 2 * num_lines;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (steps_[i].segment == s) sizes.steps[i] = amplitudes(place++);
    }
  }
  for (const double square : squares) {
    sizes.lines.push_back(std::sqrt(square / std::max(num_segments(), 1)));
  }
  return sizes;
}

LevelStep OutputErrorProblem::ToLevelStep(const SegmentStep& step,
                                          double size) const {
  const Segment& segment = segments_[step.segment];
  return {.record = segment.record,
          .time = segment.start_time + step.sample * sample_time_,
          .lag = step.lag * sample_time_,
          .size = size};
}

std::optional<SegmentStep> OutputErrorProblem::Locate(
    const LevelStep& step) const {
  for (int s = 0; s < num_segments(); ++s) {
    const Segment& segment = segments_[s];
    const int sample = static_cast<int>(
        std::lround((step.time - segment.start_time) / sample_time_));
    if (segment.record == step.record && sample > segment.times.front() &&
        sample <= segment.times.back()) {
      return SegmentStep{
          .segment = s, .sample = sample, .lag = step.lag / sample_time_};
    }
  }
  return std::nullopt;
}

void AdoptDisturbances(const NoiseEstimate& noise,
                       OutputErrorProblem& problem) {
  std::vector<double> periods;
  for (const PeriodicLine& line : noise.lines) {
    periods.push_back(line.period / problem.sample_time());
  }
  problem.SetLines(periods);
  std::vector<SegmentStep> steps;
  for (const LevelStep& step : noise.steps) {
    const std::optional<SegmentStep> place = problem.Locate(step);
    if (place.has_value()) steps.push_back(*place);
  }
  problem.SetSteps(std::move(steps));
}

void ReportDisturbances(const OutputErrorProblem& problem,
                        const OutputPoint& point, NoiseEstimate& noise) {
  const OutputErrorProblem::Sizes sizes =
      problem.DisturbanceSizes(point, ShapeOf(noise));
  noise.lines.clear();
  for (std::size_t i = 0; i < sizes.lines.size(); ++i) {
    noise.lines.push_back({.period = problem.lines()[i] * problem.sample_time(),
                           .amplitude = sizes.lines[i]});
  }
  noise.steps.clear();
  for (std::size_t i = 0; i < sizes.steps.size(); ++i) {
    noise.steps.push_back(
        problem.ToLevelStep(problem.steps()[i], sizes.steps[i]));
  }
}

}  // namespace mle
