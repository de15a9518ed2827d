#include "mle/monitor/row_response.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "mle/base/status.h"
#include "mle/nonlinear/amplitude_fit.h"
#include "mle/nonlinear/innovations_filter.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_fit.h"
#include "mle/nonlinear/step_search.h"

namespace mle {
namespace {

// Steps of an output's level that nobody measures, among the whitened samples
// around one change of set points.
//
// A step is 1 − exp(−(k − t + 1)/T) at the samples k ≥ t, 1 if T = 0 (LevelStep
// in output_error_correction.h). Of residuals e, whitened and without what the
// sensitivities, the offset and a ramp explain, clipped at four deviations s,
//
//   χ² = (xᵀe)²/(s² xᵀx),   x the step, whitened and reduced likewise,
//
// is scanned over t and T; the largest is a step where it exceeds 2 ln N + 8,
// then the next beside it, up to six. What a change of the parameters would
// explain is no step, and steps of which it would explain nine tenths are not
// looked for.

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kMostSteps = 6;
constexpr Index kBesideStep = 8;  // samples before it and after
constexpr Index kPlacesAtFirst = 64;
constexpr double kStepClip = 4.0;   // deviations
constexpr double kStepPrice = 8.0;  // of χ², beside 2 ln N
constexpr double kLeastLeft = 0.1;  // of a step, unexplained by the rest

struct StepCandidate {
  double chi_square = 0.0;
  Index row = 0;
  double lag = 0.0;
  VectorXd column;
};

// The whitened columns of the steps found (N × their number). `whitened`: the
// residual, then what is fitted beside it, one column at least; `filter` has
// whitened them, of samples at `instants`. `lags`: each T, in samples.
// `deviation`: of the residuals, at least.
MatrixXd FindLevelSteps(const std::vector<int>& instants,
                        const InnovationsFilter& filter,
                        const std::vector<double>& lags, double deviation,
                        const MatrixXd& whitened) {
  const Index rows = whitened.rows();
  MatrixXd found(rows, 0);
  if (rows <= 2 * kBesideStep + kMostSteps + whitened.cols()) return found;
  const double least = 2.0 * std::log(static_cast<double>(rows)) + kStepPrice;
  while (found.cols() < kMostSteps) {
    MatrixXd others(rows, whitened.cols() - 1 + found.cols());
    others << whitened.rightCols(whitened.cols() - 1), found;
    const AmplitudeFit rest(std::move(others));
    VectorXd residual = whitened.col(0);
    rest.TakeOut(residual);
    const double unit = std::max(
        RobustDeviationOf({residual.begin(), residual.end()}), deviation);
    if (!(unit > 0.0)) break;
    residual =
        residual.cwiseMin(kStepClip * unit).cwiseMax(-kStepClip * unit) / unit;
    StepCandidate best;
    const auto look = [&](double lag, Index from, Index to, Index stride) {
      const Index places = (to - from + stride - 1) / stride;
      MatrixXd columns = MatrixXd::Zero(rows, places);
      for (Index place = 0; place < places; ++place) {
        const Index begin = from + place * stride;
        const LevelStep step = {.time = static_cast<double>(instants[begin]),
                                .lag = lag,
                                .size = 1.0};
        for (Index row = begin; row < rows; ++row) {
          columns(row, place) = step.At(instants[row], 1.0);
        }
      }
      filter.Apply(columns);
      MatrixXd left = columns;
      rest.TakeOut(left);
      for (Index place = 0; place < places; ++place) {
        const double square = left.col(place).squaredNorm();
        if (!(square > kLeastLeft * columns.col(place).squaredNorm())) continue;
        const double product = left.col(place).dot(residual);
        if (product * product <= best.chi_square * square) continue;
        best = {product * product / square, from + place * stride, lag,
                columns.col(place)};
      }
    };
    const Index stride =
        std::max<Index>((rows - 2 * kBesideStep) / kPlacesAtFirst, 1);
    for (const double lag : lags) {
      look(lag, kBesideStep, rows - kBesideStep, stride);
    }
    if (best.chi_square > 0.0) {
      const Index row = best.row;
      look(best.lag, std::max(row - stride + 1, kBesideStep),
           std::min(row + stride, rows - kBesideStep), 1);
    }
    if (!(best.chi_square > least)) break;
    found.conservativeResize(Eigen::NoChange, found.cols() + 1);
    found.rightCols(1) = best.column;
  }
  return found;
}

using Eigen::MatrixXd;

constexpr int kLeastRows = 20;

// Half the width of the secant by a dead time, in units of it.
constexpr double kSecant = 0.1;

// Rows without what free multiples of their last `count` columns explain, which
// go too: of each column in turn every row less what those before it tell of
// the multiple, to the variance that it had. The first row that tells of it is
// used up.
MatrixXd RecursiveResiduals(MatrixXd rows, Eigen::Index count) {
  for (; count > 0; --count) {
    const Eigen::Index width = rows.cols() - 1;
    Eigen::RowVectorXd products = Eigen::RowVectorXd::Zero(width);
    Eigen::RowVectorXd row(width);
    double square = 0.0;
    Eigen::Index kept = 0;
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      const double r = rows(k, width);
      row = rows.row(k).head(width);
      if (r == 0.0) {
        rows.row(kept++).head(width) = row;
        continue;
      }
      if (square > 0.0) {
        rows.row(kept++).head(width) =
            (row - r / square * products) / std::sqrt(1.0 + r * r / square);
      }
      square += r * r;
      products += r * row;
    }
    rows = rows.topLeftCorner(kept, width).eval();
  }
  return rows;
}

}  // namespace

double RobustDeviationOf(std::vector<double> values) {
  if (values.empty()) return 0.0;
  for (double& value : values) value = std::abs(value);
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  constexpr double kToDeviation = 1.4826;
  return kToDeviation * *middle;
}

absl::StatusOr<RowResponse> RowResponse::Create(const ProcessModel& model,
                                                int output, double sample_time,
                                                int skip) {
  RowResponse row;
  row.output_ = output;
  row.skip_ = skip;
  row.sample_time_ = sample_time;
  row.elements_.resize(model.num_inputs());
  row.point_.values.resize(model.num_inputs());
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.element(output, j).IsZero()) continue;
    absl::StatusOr<ElementResponse> element =
        ElementResponse::Create(model.element(output, j));
    if (!element.ok()) {
      return InvalidArgument("watch: element of ", PairName(model, output, j),
                             ": ", element.status().message());
    }
    row.point_.values[j] = element->initial_values();
    row.elements_[j] = *std::move(element);
    row.inputs_.push_back(j);
  }
  row.point_.SetCells(sample_time);
  row.units_ = Eigen::VectorXd::Ones(row.num_parameters());
  for (std::size_t e = 0; e < row.inputs_.size(); ++e) {
    const ElementValues& values = row.point_.values[row.inputs_[e]];
    row.units_(static_cast<Eigen::Index>(3 * e + 2)) =
        std::max({values.delay, values.time_scale / 5.0, 3.0 * sample_time});
  }
  return row;
}

OutputErrorProblem RowResponse::ProblemOf(
    const std::vector<Record>& records) const {
  return OutputErrorProblem(elements_, records, output_, skip_, kLeastRows);
}

NoiseEstimate RowResponse::EstimateNoise(
    const std::vector<Record>& records) const {
  const OutputErrorProblem problem = ProblemOf(records);
  return mle::EstimateNoise(problem, point_,
                            std::vector<bool>(elements_.size(), false),
                            NoiseEstimate(), /*estimate_drift=*/true,
                            /*search_ar=*/true);
}

// The residual and the sensitivities, at the samples that count.
MatrixXd RowResponse::Columns(
    const OutputErrorProblem& problem,
    const OutputErrorProblem::Segment& segment) const {
  MatrixXd columns(segment.outputs.size(), 1 + num_parameters());
  columns.col(0) = segment.outputs;
  MatrixXd response;
  MatrixXd later;
  MatrixXd earlier;
  for (std::size_t e = 0; e < inputs_.size(); ++e) {
    const int j = inputs_[e];
    const auto first = static_cast<Eigen::Index>(1 + 3 * e);
    const double unit = units_(first + 1);
    const double width = std::max(kSecant * unit, 0.5 * sample_time_);
    const double gain = point_.values[j].gain;
    OutputPoint moved = point_;
    problem.Respond(segment, point_, j, response);
    moved.values[j].delay += width;
    moved.SetCells(sample_time_);
    problem.Respond(segment, moved, j, later, /*derivatives=*/false);
    moved.values[j].delay = std::max(point_.values[j].delay - width, 0.0);
    const double span = point_.values[j].delay + width - moved.values[j].delay;
    moved.SetCells(sample_time_);
    problem.Respond(segment, moved, j, earlier, /*derivatives=*/false);
    for (Eigen::Index row = 0; row < columns.rows(); ++row) {
      const int k = segment.times[row];
      columns(row, 0) -= gain * response(k, 0);
      columns(row, first) = gain * response(k, 0);
      columns(row, first + 1) = gain * response(k, 1);
      columns(row, first + 2) =
          gain * (later(k, 0) - earlier(k, 0)) * unit / span;
    }
  }
  return columns;
}

std::vector<WhitenedRun> RowResponse::Whiten(const Record& record,
                                             const NoiseEstimate& noise,
                                             const std::vector<int>& groups,
                                             double step_deviation) const {
  const OutputErrorProblem problem = ProblemOf({record});
  const std::vector<double> lags = StepLags(problem, point_);
  const auto width = static_cast<Eigen::Index>(1 + num_parameters());
  std::vector<WhitenedRun> runs;
  for (int s = 0; s < problem.num_segments(); ++s) {
    const MatrixXd all = Columns(problem, problem.segment(s));
    const std::vector<int>& times = problem.times(s);
    const auto start = static_cast<std::size_t>(
        std::lround((problem.segment(s).start_time - record.start_time) /
                    record.sample_time));
    const auto group_of = [&](std::size_t row) {
      return groups.empty()
                 ? 0
                 : groups[start + static_cast<std::size_t>(times[row])];
    };
    for (std::size_t begin = 0, end = 0; begin < times.size(); begin = end) {
      while (end < times.size() && group_of(end) == group_of(begin)) ++end;
      MatrixXd columns = all.middleRows(static_cast<Eigen::Index>(begin),
                                        static_cast<Eigen::Index>(end - begin));
      const std::vector<int> instants(
          times.begin() + static_cast<std::ptrdiff_t>(begin),
          times.begin() + static_cast<std::ptrdiff_t>(end));
      if (problem.is_integrating()) AppendRamp(instants, columns);
      const InnovationsFilter filter(instants, ShapeOf(noise));
      filter.Apply(columns);
      columns.leftCols(width) /= std::sqrt(noise.variance);
      if (step_deviation > 0.0) {
        const MatrixXd steps =
            FindLevelSteps(instants, filter, lags, step_deviation, columns);
        const Eigen::Index known = columns.cols();
        columns.conservativeResize(Eigen::NoChange, known + steps.cols());
        columns.rightCols(steps.cols()) = steps;
      }
      // The first row is taken up by the offset.
      if (noise.offset) columns = columns.bottomRows(columns.rows() - 1).eval();
      columns = RecursiveResiduals(columns, columns.cols() - width);
      if (columns.rows() == 0) continue;
      runs.push_back({columns.col(0), columns.rightCols(num_parameters()),
                      group_of(begin)});
    }
  }
  return runs;
}

}  // namespace mle
