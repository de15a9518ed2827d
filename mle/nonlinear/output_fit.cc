#include "mle/nonlinear/output_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "ceres/ceres.h"
#include "glog/logging.h"
#include "mle/nonlinear/delay_search.h"
#include "mle/nonlinear/output_cost.h"

namespace mle {
namespace {

using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxGridPoints = 64;
constexpr int kMaxNoiseRounds = 8;
constexpr int kMaxSearchRounds = 5;
constexpr int kMaxCellMoves = 100;
constexpr int kMaxHoldRounds = 8;
// Weights of a robust loss are done where none moves by more than this.
constexpr int kMaxRobustRounds = 30;
constexpr double kWeightTolerance = 1e-3;
// A shape stays where logarithms of ρ, σ and 1 − φ move less, or where ratios
// are below any effect.
constexpr double kShapeTolerance = 0.02;
// A dead time this close to the end of its sample (in samples) is at it.
constexpr double kCellTolerance = 1e-7;
// A move of an input has an effect for dead time + this many time scales.
constexpr double kMemoryTimeScales = 5.0;

// What Fitter::Solve() may move, and how far it goes.
struct SolveOptions {
  bool within_cells = false;  // dead times within their samples
  bool exact = false;
  std::vector<bool> held = {};  // dead times that stay; empty: none
};

class Fitter {
 public:
  Fitter(const OutputErrorProblem& problem, const std::vector<bool>& free,
         const OutputFitBounds& bounds, const OutputErrorOptions& options)
      : problem_(problem), free_(free), bounds_(bounds), options_(options) {}

  FitCertificate& certificate() { return certificate_; }

  // Steps 1 and 2: from the best of several searches.
  OutputPoint Start(const OutputPoint& start, const NoiseShape& shape) {
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

  DelaySearchResult Search(const OutputPoint& point, const NoiseShape& shape) {
    ++certificate_.grid_searches;
    return SearchDelays(problem_, point, shape, free_, bounds_.max_delays,
                        kMaxGridPoints);
  }

  // Step 2: all dead times, then sample by sample. Returns the cost.
  double Refine(OutputPoint& point, const NoiseShape& shape) {
    Solve(point, shape);
    double cost = SolveWithinCells(point, shape);
    for (int move = 0; move < kMaxCellMoves; ++move) {
      OutputPoint moved = point;
      if (!MoveCells(moved, shape)) break;
      const double moved_cost = SolveWithinCells(moved, shape);
      if (!(moved_cost < cost * (1.0 - 1e-12))) break;
      cost = moved_cost;
      point = moved;
    }
    return cost;
  }

  // Of the certificate: derivatives at the end, in standard deviations.
  void CertifyGradient(const OutputPoint& point, const NoiseEstimate& noise) {
    const WhitenedColumns whitened = problem_.Whiten(
        problem_.Linearise(point, ShapeOf(noise), true), ShapeOf(noise));
    certificate_.gradient = 0.0;
    certificate_.at_bound = false;
    const double scale = std::sqrt(noise.variance);
    for (int j = 0; j < problem_.num_elements(); ++j) {
      if (!free_[j]) continue;
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
        const auto column = whitened.jacobian.col(3 * j + i);
        const double norm = column.norm();
        if (!(norm > 0.0) || !(scale > 0.0)) continue;
        certificate_.gradient =
            std::max(certificate_.gradient,
                     std::abs(column.dot(whitened.residuals)) / (norm * scale));
      }
    }
  }

 private:
  // Within the samples that the dead times lie in. Those whose cost falls
  // beyond an end of their sample stay there: steps projected on bounds would
  // only creep towards the optimum of the others.
  double SolveWithinCells(OutputPoint& point, const NoiseShape& shape) {
    std::vector<bool> held(free_.size(), false);
    double cost = Solve(point, shape, {.within_cells = true});
    for (int round = 0; round < kMaxHoldRounds; ++round) {
      const std::vector<bool> former = held;
      held = AtEnds(point, shape);
      if (round > 0 && held == former) break;
      cost = Solve(point, shape,
                   {.within_cells = true, .exact = true, .held = held});
    }
    return cost;
  }

  // The dead times at an end of their sample beyond which the cost falls.
  std::vector<bool> AtEnds(const OutputPoint& point,
                           const NoiseShape& shape) const {
    const WhitenedColumns whitened =
        problem_.Whiten(problem_.Linearise(point, shape, true), shape);
    std::vector<bool> ends(free_.size(), false);
    for (int j = 0; j < problem_.num_elements(); ++j) {
      if (!free_[j]) continue;
      const int end = EndOf(point, j);
      const double slope =
          whitened.jacobian.col(3 * j + 2).dot(whitened.residuals);
      ends[j] = end != 0 && end * slope <= 0.0;
    }
    return ends;
  }

  // Of the sample that the dead time lies in, within its bounds.
  std::pair<double, double> DelaysOf(const OutputPoint& point, int j) const {
    const double sample_time = problem_.sample_time();
    return {
        point.cells[j] * sample_time,
        std::min(bounds_.max_delays[j], (point.cells[j] + 1) * sample_time)};
  }

  // The end of that sample which the dead time is at: −1 or 1; 0: none.
  int EndOf(const OutputPoint& point, int j) const {
    const auto [low, high] = DelaysOf(point, j);
    const double near = kCellTolerance * problem_.sample_time();
    if (point.values[j].delay < low + near) return -1;
    return point.values[j].delay > high - near ? 1 : 0;
  }

  // Levenberg–Marquardt from and to `point`; returns the cost.
  double Solve(OutputPoint& point, const NoiseShape& shape,
               const SolveOptions& options = {}) {
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

  void SetBounds(const OutputPoint& point, int j, const SolveOptions& options,
                 double* block, ceres::Problem& problem) const {
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
    if (!options.held.empty() && options.held[j]) {
      problem.SetManifold(block, new ceres::SubsetManifold(3, {2}));
    }
  }

  // Takes each dead time at an end of its sample into the next one if the cost
  // falls there; false if none does.
  bool MoveCells(OutputPoint& point, const NoiseShape& shape) const {
    bool moved = false;
    for (int j = 0; j < problem_.num_elements(); ++j) {
      if (!free_[j]) continue;
      const int direction = EndOf(point, j);
      const bool has_next =
          direction < 0 ? point.cells[j] > 0
                        : (point.cells[j] + 1) * problem_.sample_time() <
                              bounds_.max_delays[j];
      if (direction == 0 || !has_next) continue;
      OutputPoint trial = point;
      trial.cells[j] += direction;
      const WhitenedColumns whitened =
          problem_.Whiten(problem_.Linearise(trial, shape, true), shape);
      const double slope =
          whitened.jacobian.col(3 * j + 2).dot(whitened.residuals);
      if (slope * direction < 0.0) {
        point = trial;
        moved = true;
      }
    }
    return moved;
  }

  const OutputErrorProblem& problem_;
  const std::vector<bool>& free_;
  const OutputFitBounds& bounds_;
  const OutputErrorOptions& options_;
  FitCertificate certificate_;
};

// Bursts of outliers look like a colour, and what is taken for colour is not
// down-weighted: a robust loss finds its weights first.
bool MayHaveColour(const OutputErrorProblem& problem,
                   const OutputErrorOptions& options) {
  return options.robust_loss == RobustLoss::kNone ||
         problem.weights().size() > 0;
}

bool SameShape(const NoiseEstimate& a, const NoiseEstimate& b) {
  const auto same = [](double x, double y) {
    const double floor = 1e-10;
    return std::abs(std::log((x + floor) / (y + floor))) < kShapeTolerance;
  };
  return a.offset == b.offset && same(a.ratio, b.ratio) &&
         same(a.colour_ratio, b.colour_ratio) &&
         same(1.0 - a.colour_pole, 1.0 - b.colour_pole) &&
         same(a.colour_damping, b.colour_damping);
}

// Steps 2 to 4 and what is reported, from `fit`'s values and noise.
void Finish(const OutputErrorProblem& problem,
            const OutputErrorOptions& options, Fitter& fitter, OutputFit& fit) {
  FitCertificate& certificate = fitter.certificate();
  for (int round = 0; round < kMaxSearchRounds; ++round) {
    double cost = 0.0;
    for (int again = 0; again < kMaxNoiseRounds; ++again) {
      const NoiseEstimate former = fit.noise;
      fit.noise = EstimateNoise(problem, fit.point, fit.free, former,
                                options.estimate_drift,
                                again == 1 && MayHaveColour(problem, options));
      cost = fitter.Refine(fit.point, ShapeOf(fit.noise));
      if (again > 0 && SameShape(former, fit.noise)) break;
    }
    const DelaySearchResult search =
        fitter.Search(fit.point, ShapeOf(fit.noise));
    certificate.search_confirmed =
        !(search.cost < cost * (1.0 - 1e-9) - search.cost_accuracy);
    if (certificate.search_confirmed) break;
    fit.point = search.point;
  }
  fit.noise = EstimateNoise(problem, fit.point, fit.free, fit.noise,
                            options.estimate_drift, /*search_colour=*/false);
  fitter.CertifyGradient(fit.point, fit.noise);
}

// The samples for which a move of an input has an effect.
int LongestMemory(const OutputErrorProblem& problem, const OutputFit& fit) {
  double longest = 0.0;
  for (std::size_t j = 0; j < fit.free.size(); ++j) {
    if (!fit.free[j]) continue;
    const ElementValues& values = fit.point.values[j];
    longest =
        std::max(longest, values.delay + kMemoryTimeScales * values.time_scale);
  }
  return static_cast<int>(std::min(longest / problem.sample_time(), 1e9));
}

void FillIn(const OutputErrorProblem& problem,
            const OutputErrorOptions& options, FitCertificate certificate,
            OutputFit& fit) {
  const std::vector<SegmentColumns> columns =
      LineariseWidely(problem, fit.point, fit.free, fit.noise);
  const OutputCovariance covariance =
      CovarianceOf(problem.Whiten(columns, ShapeOf(fit.noise)), fit.point,
                   fit.free, fit.noise.variance);
  fit.inflation = InflationOf(problem, fit.point, columns, fit.free,
                              ShapeOf(fit.noise), LongestMemory(problem, fit));
  fit.noise.inflation = fit.inflation.statistic;
  fit.noise.samples_at_rest =
      problem.at_rest() != nullptr ? problem.at_rest()->num_samples() : 0;
  fit.covariance = fit.inflation.Scale(covariance.covariance);
  fit.degrees_of_freedom =
      ComputeDegreesOfFreedom(problem, fit.point, fit.free, fit.noise);
  fit.deviance =
      Deviance(problem, fit.point, fit.free, fit.noise, options.estimate_drift);
  certificate.condition = covariance.condition;
  certificate.rank = covariance.rank;
  certificate.num_parameters =
      3 * static_cast<int>(std::count(fit.free.begin(), fit.free.end(), true));
  fit.certificate = certificate;
}

// The weights at `fit`; returns by how much any of them moves.
double Reweight(RobustLoss loss, const OutputFit& fit,
                OutputErrorProblem& problem) {
  const RobustWeights robust = ComputeRobustWeights(
      loss, problem.WhiteResiduals(fit.point, ShapeOf(fit.noise)));
  const VectorXd former = problem.weights().size() > 0
                              ? problem.weights()
                              : VectorXd::Ones(robust.weights.size());
  problem.SetWeights(robust.weights, robust.variance_factor);
  return (robust.weights - former).cwiseAbs().maxCoeff();
}

}  // namespace

OutputFit FitOutput(const OutputErrorProblem& problem, const OutputPoint& start,
                    const std::vector<bool>& free,
                    const OutputFitBounds& bounds,
                    const OutputErrorOptions& options) {
  OutputFit fit;
  fit.free = free;
  fit.point = start;
  fit.point.SetCells(problem.sample_time());
  // At the start the model's error would be taken for colour.
  const bool any = std::find(free.begin(), free.end(), true) != free.end();
  fit.noise = EstimateNoise(problem, fit.point, free, NoiseEstimate(),
                            options.estimate_drift,
                            !any && MayHaveColour(problem, options));
  Fitter fitter(problem, fit.free, bounds, options);
  if (!any) {
    FitCertificate certificate;
    certificate.termination = FitTermination::kConverged;
    certificate.message = "no parameter is free";
    certificate.gradient = 0.0;
    certificate.search_confirmed = true;
    FillIn(problem, options, certificate, fit);
    return fit;
  }
  fit.point = fitter.Start(fit.point, ShapeOf(fit.noise));
  Finish(problem, options, fitter, fit);
  FillIn(problem, options, fitter.certificate(), fit);
  return fit;
}

OutputFit Refit(const OutputErrorProblem& problem, const OutputFit& fit,
                const OutputFitBounds& bounds,
                const OutputErrorOptions& options) {
  OutputFit again = fit;
  FitCertificate certificate = fit.certificate;
  if (fit.certificate.num_parameters > 0) {
    Fitter fitter(problem, again.free, bounds, options);
    Finish(problem, options, fitter, again);
    certificate = fitter.certificate();
  } else {
    again.noise =
        EstimateNoise(problem, again.point, again.free, again.noise,
                      options.estimate_drift, MayHaveColour(problem, options));
  }
  certificate.weight_change = fit.certificate.weight_change;
  FillIn(problem, options, certificate, again);
  return again;
}

OutputFit FitWithoutOffsets(const OutputErrorProblem& problem,
                            const OutputFit& fit, const OutputFitBounds& bounds,
                            const OutputErrorOptions& options) {
  OutputFit plain = fit;
  plain.noise = NoiseEstimate();
  plain.noise.offset = false;
  return Refit(problem, plain, bounds, options);
}

void FitRobustly(const OutputFitBounds& bounds,
                 const OutputErrorOptions& options, OutputErrorProblem& problem,
                 OutputFit& fit) {
  if (problem.num_segments() == 0) return;
  Fitter fitter(problem, fit.free, bounds, options);
  const bool parameters = fit.certificate.num_parameters > 0;
  double change = kInfinity;
  for (int search = 0; search < kMaxSearchRounds && change > kWeightTolerance;
       ++search) {
    // Weights from nearby, then the search for dead times once more.
    for (int round = 0; round < kMaxRobustRounds; ++round) {
      change = Reweight(options.robust_loss, fit, problem);
      if (change <= kWeightTolerance) break;
      fit.noise = EstimateNoise(problem, fit.point, fit.free, fit.noise,
                                options.estimate_drift,
                                /*search_colour=*/false);
      if (parameters) fitter.Refine(fit.point, ShapeOf(fit.noise));
    }
    fit = Refit(problem, fit, bounds, options);
    change = Reweight(options.robust_loss, fit, problem);
  }
  // At the weights of the final residuals: the robust loss's own gradient.
  if (parameters) {
    fitter.CertifyGradient(fit.point, fit.noise);
    fit.certificate.gradient = fitter.certificate().gradient;
  }
  fit.certificate.weight_change = change;
}

}  // namespace mle
