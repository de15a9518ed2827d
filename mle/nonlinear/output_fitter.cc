#include "mle/nonlinear/output_fitter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ceres/ceres.h"
#include "mle/base/double_limits.h"
#include "mle/nonlinear/box_least_squares.h"
#include "mle/nonlinear/output_cost.h"

namespace mle {
namespace {

// Dead times a quarter of a time constant apart: steps from the best of them
// reach the optimum between.
constexpr DelayGrid kDelayGrid = {.max_points = 64, .share = 0.25};
constexpr int kMaxCellMoves = 100;
constexpr int kMaxHoldRounds = 8;
// A dead time this close to the end of its sample (in samples) is at it.
constexpr double kCellTolerance = 1e-7;
// Rough solves end with the step before which the objective could fall by this
// share of the squares of one sample; those with dead times in any sample, at
// whose ends the slope jumps, ten times as early: solves within samples follow.
constexpr double kRoughDecrease = 4e-3;
constexpr double kFreeDecrease = 4e-2;

}  // namespace

OutputPoint Fitter::Start(const OutputPoint& start, const NoiseShape& shape) {
  OutputPoint best = start;
  double best_cost = kInfinity;
  for (const double factor : {1.0, 0.5, 2.0}) {
    OutputPoint point = start;
    for (std::size_t j = 0; j < free_.size(); ++j) {
      if (!free_[j]) continue;
      point.values[j].time_scale =
          std::clamp(factor * point.values[j].time_scale,
                     bounds_.min_time_scales[j], bounds_.max_time_scales[j]);
    }
    point = Search(point, shape).point;
    const double cost = SolveRoughly(point, shape, /*within_cells=*/false);
    if (cost < best_cost) {
      best_cost = cost;
      best = point;
    }
  }
  return best;
}

DelaySearchResult Fitter::Search(const OutputPoint& point,
                                 const NoiseShape& shape) {
  ++certificate_.grid_searches;
  return SearchDelays(problem_, point, shape, free_, bounds_.max_delays,
                      kDelayGrid);
}

double Fitter::CostOf(const OutputPoint& point, const NoiseShape& shape) const {
  return ModelAt(point, shape, free_).cost;
}

double Fitter::RefineRoughly(OutputPoint& point, const NoiseShape& shape,
                             bool near) {
  if (!near) SolveRoughly(point, shape, /*within_cells=*/false);
  return Move(point, shape, /*exact=*/false,
              SolveWithinCells(point, shape, /*exact=*/false));
}

double Fitter::RefineExactly(OutputPoint& point, const NoiseShape& shape) {
  return Move(point, shape, /*exact=*/true,
              SolveWithinCells(point, shape, /*exact=*/true));
}

double Fitter::Move(OutputPoint& point, const NoiseShape& shape, bool exact,
                    double cost) {
  for (int move = 0; move < kMaxCellMoves; ++move) {
    OutputPoint moved = point;
    if (!MoveCells(moved, shape)) break;
    const double moved_cost = SolveWithinCells(moved, shape, exact);
    if (!(moved_cost < cost * (1.0 - 1e-12))) break;
    cost = moved_cost;
    point = moved;
  }
  return cost;
}

void Fitter::CertifyGradient(const OutputPoint& point,
                             const NoiseEstimate& noise) {
  const WhitenedColumns whitened = problem_.Whiten(
      problem_.Linearise(point, ShapeOf(noise), free_), ShapeOf(noise));
  certificate_.gradient = 0.0;
  certificate_.at_bound = false;
  const double scale = std::sqrt(noise.variance);
  Eigen::Index first = -3;  // column of the element
  for (int j = 0; j < problem_.num_elements(); ++j) {
    if (!free_[j]) continue;
    first += 3;
    const double log_scale = std::log(point.values[j].time_scale);
    const bool at_time_bound =
        log_scale < std::log(bounds_.min_time_scales[j]) + 1e-6 ||
        log_scale > std::log(bounds_.max_time_scales[j]) - 1e-6;
    const bool at_kink = EndOf(point, j) != 0;
    certificate_.at_bound |=
        at_time_bound || point.values[j].delay <= 0.0 ||
        point.values[j].delay > bounds_.max_delays[j] - 1e-9;
    for (int i = 0; i < 3; ++i) {
      if ((i == 1 && at_time_bound) || (i == 2 && at_kink)) continue;
      const auto column = whitened.jacobian.col(first + i);
      const double norm = column.norm();
      if (!(norm > 0.0) || !(scale > 0.0)) continue;
      certificate_.gradient =
          std::max(certificate_.gradient,
                   std::abs(column.dot(whitened.residuals)) / (norm * scale));
    }
  }
}

double Fitter::SolveWithinCells(OutputPoint& point, const NoiseShape& shape,
                                bool exact) {
  const double cost = SolveRoughly(point, shape, /*within_cells=*/true);
  return exact ? SolveExactly(point, shape, cost) : cost;
}

double Fitter::SolveExactly(OutputPoint& point, const NoiseShape& shape,
                            double cost) {
  std::vector<bool> held(free_.size(), false);
  for (int round = 0; round < kMaxHoldRounds; ++round) {
    const std::vector<bool> former = held;
    held = AtEnds(point, shape);
    if (round > 0 && held == former) break;
    cost = SolveByCeres(point, shape, held);
  }
  return cost;
}

QuadraticModel Fitter::ModelAt(const OutputPoint& point,
                               const NoiseShape& shape,
                               const std::vector<bool>& by) const {
  std::vector<double> x;
  for (int j = 0; j < problem_.num_elements(); ++j) {
    if (!problem_.elements()[j].has_value() || !by[j]) continue;
    const ElementValues& v = point.values[j];
    x.insert(x.end(), {v.gain, std::log(v.time_scale), v.delay});
  }
  const Eigen::Map<const Eigen::VectorXd> values(
      x.data(), static_cast<Eigen::Index>(x.size()));
  return MakeOutputModel(problem_, point, by, shape,
                         /*fixed_cells=*/true)(values);
}

std::vector<bool> Fitter::AtEnds(const OutputPoint& point,
                                 const NoiseShape& shape) const {
  std::vector<bool> ends(free_.size(), false);
  for (const int j : Moved()) ends[j] = EndOf(point, j) != 0;
  if (std::find(ends.begin(), ends.end(), true) == ends.end()) return ends;
  const QuadraticModel model = ModelAt(point, shape, ends);
  Eigen::Index by_delay = 2;
  for (std::size_t j = 0; j < ends.size(); ++j) {
    if (!ends[j]) continue;
    ends[j] =
        EndOf(point, static_cast<int>(j)) * model.gradient(by_delay) <= 0.0;
    by_delay += 3;
  }
  return ends;
}

std::pair<double, double> Fitter::DelaysOf(const OutputPoint& point,
                                           int j) const {
  const double sample_time = problem_.sample_time();
  return {point.cells[j] * sample_time,
          std::min(bounds_.max_delays[j], (point.cells[j] + 1) * sample_time)};
}

int Fitter::EndOf(const OutputPoint& point, int j) const {
  const auto [low, high] = DelaysOf(point, j);
  const double near = kCellTolerance * problem_.sample_time();
  if (point.values[j].delay < low + near) return -1;
  return point.values[j].delay > high - near ? 1 : 0;
}

std::vector<int> Fitter::Moved() const {
  std::vector<int> moved;
  for (int j = 0; j < problem_.num_elements(); ++j) {
    if (problem_.elements()[j].has_value() && free_[j]) moved.push_back(j);
  }
  return moved;
}

Fitter::Box Fitter::BoxOf(const OutputPoint& point, int j, bool within_cells,
                          bool held) const {
  const double sample_time = problem_.sample_time();
  const auto [low, high] =
      within_cells ? DelaysOf(point, j) : std::pair(0.0, bounds_.max_delays[j]);
  // Ceres wants an interval, and a start inside it.
  const double end = std::max(high, low + 1e-9 * sample_time);
  const ElementValues& v = point.values[j];
  Box box;
  box.lower = {-kInfinity, std::log(bounds_.min_time_scales[j]), low};
  box.upper = {kInfinity, std::log(bounds_.max_time_scales[j]), end};
  box.start = {v.gain,
               std::clamp(std::log(v.time_scale), box.lower[1], box.upper[1]),
               std::clamp(v.delay, low, end)};
  box.constant = {false, !problem_.elements()[j]->has_time_scale(), held};
  return box;
}

double Fitter::SolveRoughly(OutputPoint& point, const NoiseShape& shape,
                            bool within_cells) {
  const std::vector<int> moved = Moved();
  const auto size = 3 * static_cast<Eigen::Index>(moved.size());
  Eigen::VectorXd x(size);
  Eigen::VectorXd lower(size);
  Eigen::VectorXd upper(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Box box = BoxOf(point, moved[i / 3], within_cells, /*held=*/false);
    x(i) = box.start[i % 3];
    const bool constant = box.constant[i % 3];
    lower(i) = constant ? x(i) : box.lower[i % 3];
    upper(i) = constant ? x(i) : box.upper[i % 3];
  }
  const double decrease = within_cells ? kRoughDecrease : kFreeDecrease;
  const BoxLeastSquaresSummary summary = MinimiseWithinBox(
      MakeOutputModel(problem_, point, free_, shape, within_cells), lower,
      upper,
      {.max_iterations = options_.max_iterations,
       .tolerance = decrease / std::max(problem_.num_samples(), 1)},
      x);
  certificate_.iterations += summary.iterations;
  certificate_.message = summary.converged
                             ? "no step lowers the objective"
                             : "Maximum number of iterations reached";
  certificate_.termination = summary.converged
                                 ? FitTermination::kConverged
                                 : FitTermination::kIterationLimit;
  if (!std::isfinite(summary.cost)) {
    certificate_.termination = FitTermination::kFailed;
    certificate_.message = "the objective is not a finite number";
    return kInfinity;
  }
  for (std::size_t f = 0; f < moved.size(); ++f) {
    const Eigen::Index first = 3 * static_cast<Eigen::Index>(f);
    point.values[moved[f]] = {x(first), std::exp(x(first + 1)), x(first + 2)};
  }
  if (!within_cells) point.SetCells(problem_.sample_time());
  return summary.cost;
}

double Fitter::SolveByCeres(OutputPoint& point, const NoiseShape& shape,
                            const std::vector<bool>& held) {
  const std::vector<int> moved = Moved();
  std::vector<Box> boxes;
  ceres::Problem problem;
  std::vector<double*> blocks;
  boxes.reserve(moved.size());
  for (const int j : moved) {
    boxes.push_back(BoxOf(point, j, /*within_cells=*/true, held[j]));
    blocks.push_back(boxes.back().start.data());
  }
  problem.AddResidualBlock(
      MakeOutputCost(problem_, point, free_, shape, /*fixed_cells=*/true)
          .release(),
      nullptr, blocks);
  for (std::size_t b = 0; b < moved.size(); ++b) {
    SetBounds(boxes[b], blocks[b], problem);
  }
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  ceres_options.max_num_iterations = options_.max_iterations;
  ceres_options.function_tolerance = 1e-13;
  ceres_options.parameter_tolerance = 1e-11;
  ceres_options.gradient_tolerance = 0.0;
  // Steps are projected on the bounds; a search along each, which Ceres makes
  // besides where there are bounds, takes more evaluations than it saves.
  ceres_options.max_num_line_search_step_size_iterations = 0;
  ceres_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &problem, &summary);

  certificate_.iterations += static_cast<int>(summary.iterations.size());
  certificate_.message = summary.message;
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
    case ceres::USER_SUCCESS:
      certificate_.termination = FitTermination::kConverged;
      break;
    case ceres::NO_CONVERGENCE:
      certificate_.termination = FitTermination::kIterationLimit;
      break;
    default:
      certificate_.termination = FitTermination::kFailed;
      return kInfinity;
  }
  for (std::size_t b = 0; b < moved.size(); ++b) {
    const std::array<double, 3>& x = boxes[b].start;
    point.values[moved[b]] = {x[0], std::exp(x[1]), x[2]};
  }
  return summary.final_cost;
}

void Fitter::SetBounds(const Box& box, double* block, ceres::Problem& problem) {
  std::vector<int> constant;
  for (int i = 0; i < 3; ++i) {
    if (std::isfinite(box.lower[i])) {
      problem.SetParameterLowerBound(block, i, box.lower[i]);
      problem.SetParameterUpperBound(block, i, box.upper[i]);
    }
    if (box.constant[i]) constant.push_back(i);
  }
  if (!constant.empty()) {
    problem.SetManifold(block, new ceres::SubsetManifold(3, constant));
  }
}

bool Fitter::MoveCells(OutputPoint& point, const NoiseShape& shape) const {
  std::vector<bool> at_end(free_.size(), false);
  OutputPoint beyond = point;
  for (const int j : Moved()) {
    const int direction = EndOf(point, j);
    const bool has_next = direction < 0
                              ? point.cells[j] > 0
                              : (point.cells[j] + 1) * problem_.sample_time() <
                                    bounds_.max_delays[j];
    if (direction == 0 || !has_next) continue;
    at_end[j] = true;
    beyond.cells[j] += direction;
  }
  if (std::find(at_end.begin(), at_end.end(), true) == at_end.end()) {
    return false;
  }
  // Responses are the same on both sides of an end: so are the residuals, and
  // one model serves all elements.
  const QuadraticModel model = ModelAt(beyond, shape, at_end);
  bool moved = false;
  Eigen::Index by_delay = 2;
  for (int j = 0; j < problem_.num_elements(); ++j) {
    if (!at_end[j]) continue;
    const int direction = beyond.cells[j] - point.cells[j];
    const double slope = model.gradient(by_delay);
    by_delay += 3;
    if (!(slope * direction < 0.0)) continue;
    point.cells[j] = beyond.cells[j];
    moved = true;
  }
  return moved;
}

}  // namespace mle
