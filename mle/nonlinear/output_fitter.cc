#include "mle/nonlinear/output_fitter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ceres/ceres.h"
#include "mle/nonlinear/output_cost.h"

namespace mle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxGridPoints = 64;
constexpr int kMaxCellMoves = 100;
constexpr int kMaxHoldRounds = 8;
// A dead time this close to the end of its sample (in samples) is at it.
constexpr double kCellTolerance = 1e-7;

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
    const double cost = Solve(point, shape);
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
                      kMaxGridPoints);
}

double Fitter::Refine(OutputPoint& point, const NoiseShape& shape, bool near) {
  const double cost = RefineRoughly(point, shape, near);
  if (options_.start != nullptr) return cost;
  return Move(point, shape, /*exact=*/true,
              SolveWithinCells(point, shape, /*exact=*/true));
}

double Fitter::RefineRoughly(OutputPoint& point, const NoiseShape& shape,
                             bool near) {
  if (!near) Solve(point, shape);
  return Move(point, shape, /*exact=*/false,
              SolveWithinCells(point, shape, /*exact=*/false));
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
  std::vector<bool> held(free_.size(), false);
  double cost = Solve(point, shape, {.within_cells = true});
  for (int round = 0; round < kMaxHoldRounds; ++round) {
    const std::vector<bool> former = held;
    held = AtEnds(point, shape);
    if ((round > 0 || !exact) && held == former) break;
    cost = Solve(point, shape,
                 {.within_cells = true, .exact = exact, .held = held});
  }
  return cost;
}

std::vector<bool> Fitter::AtEnds(const OutputPoint& point,
                                 const NoiseShape& shape) const {
  std::vector<bool> ends(free_.size(), false);
  for (int j = 0; j < problem_.num_elements(); ++j) {
    ends[j] = free_[j] && EndOf(point, j) != 0;
  }
  if (std::find(ends.begin(), ends.end(), true) == ends.end()) return ends;
  const WhitenedColumns whitened =
      problem_.Whiten(problem_.Linearise(point, shape, ends), shape);
  Eigen::Index by_delay = 2;
  for (int j = 0; j < problem_.num_elements(); ++j) {
    if (!ends[j]) continue;
    const double slope =
        whitened.jacobian.col(by_delay).dot(whitened.residuals);
    ends[j] = EndOf(point, j) * slope <= 0.0;
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

double Fitter::Solve(OutputPoint& point, const NoiseShape& shape,
                     const SolveOptions& options) {
  std::vector<int> moved;
  for (int j = 0; j < problem_.num_elements(); ++j) {
    if (problem_.elements()[j].has_value() && free_[j]) moved.push_back(j);
  }
  std::vector<std::array<double, 3>> x;
  x.reserve(moved.size());
  for (const int j : moved) {
    const ElementValues& v = point.values[j];
    x.push_back({v.gain, std::log(v.time_scale), v.delay});
  }
  std::vector<double*> blocks;
  for (auto& block : x) blocks.push_back(block.data());
  ceres::Problem problem;
  problem.AddResidualBlock(
      MakeOutputCost(problem_, point, free_, shape, options.within_cells)
          .release(),
      nullptr, blocks);
  for (std::size_t b = 0; b < moved.size(); ++b) {
    SetBounds(point, moved[b], options, blocks[b], problem);
  }
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  ceres_options.max_num_iterations = options_.max_iterations;
  ceres_options.function_tolerance = options.exact ? 1e-13 : 1e-8;
  ceres_options.parameter_tolerance = options.exact ? 1e-11 : 1e-8;
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
    point.values[moved[b]] = {x[b][0], std::exp(x[b][1]), x[b][2]};
  }
  if (!options.within_cells) point.SetCells(problem_.sample_time());
  return summary.final_cost;
}

void Fitter::SetBounds(const OutputPoint& point, int j,
                       const SolveOptions& options, double* block,
                       ceres::Problem& problem) const {
  const double sample_time = problem_.sample_time();
  const auto [low, high] = options.within_cells
                               ? DelaysOf(point, j)
                               : std::pair(0.0, bounds_.max_delays[j]);
  // Ceres wants an interval, and a start inside it.
  const double end = std::max(high, low + 1e-9 * sample_time);
  const double min_log = std::log(bounds_.min_time_scales[j]);
  const double max_log = std::log(bounds_.max_time_scales[j]);
  block[1] = std::clamp(block[1], min_log, max_log);
  block[2] = std::clamp(block[2], low, end);
  problem.SetParameterLowerBound(block, 1, min_log);
  problem.SetParameterUpperBound(block, 1, max_log);
  problem.SetParameterLowerBound(block, 2, low);
  problem.SetParameterUpperBound(block, 2, end);
  std::vector<int> constant;
  if (!problem_.elements()[j]->has_time_scale()) constant.push_back(1);
  if (!options.held.empty() && options.held[j]) constant.push_back(2);
  if (!constant.empty()) {
    problem.SetManifold(block, new ceres::SubsetManifold(3, constant));
  }
}

bool Fitter::MoveCells(OutputPoint& point, const NoiseShape& shape) const {
  bool moved = false;
  for (int j = 0; j < problem_.num_elements(); ++j) {
    if (!free_[j]) continue;
    const int direction = EndOf(point, j);
    const bool has_next = direction < 0
                              ? point.cells[j] > 0
                              : (point.cells[j] + 1) * problem_.sample_time() <
                                    bounds_.max_delays[j];
    if (direction == 0 || !has_next) continue;
    OutputPoint trial = point;
    trial.cells[j] += direction;
    std::vector<bool> alone(free_.size(), false);
    alone[j] = true;
    const WhitenedColumns whitened =
        problem_.Whiten(problem_.Linearise(trial, shape, alone), shape);
    const double slope = whitened.jacobian.col(2).dot(whitened.residuals);
    if (slope * direction < 0.0) {
      point = trial;
      moved = true;
    }
  }
  return moved;
}

}  // namespace mle
