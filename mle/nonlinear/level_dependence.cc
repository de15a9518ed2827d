#include "mle/nonlinear/level_dependence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

using Eigen::MatrixXd;

// Mean of an input over the segments, and its largest distance from it.
struct Level {
  double mean = 0.0;
  double range = 0.0;
};

Level LevelOf(const OutputErrorProblem& problem, int j) {
  Level level;
  double samples = 0.0;
  for (int s = 0; s < problem.num_segments(); ++s) {
    level.mean += problem.segment(s).inputs.col(j).sum();
    samples += static_cast<double>(problem.segment(s).inputs.rows());
  }
  level.mean /= std::max(samples, 1.0);
  for (int s = 0; s < problem.num_segments(); ++s) {
    level.range = std::max(
        level.range, (problem.segment(s).inputs.col(j).array() - level.mean)
                         .abs()
                         .maxCoeff());
  }
  return level;
}

// Responses of element j to (u_j − ū_j)²/h_j, of each segment.
std::vector<MatrixXd> CurvedResponses(const OutputErrorProblem& problem,
                                      const OutputPoint& point, int j,
                                      const Level& level) {
  std::vector<MatrixXd> columns;
  MatrixXd response;
  for (int s = 0; s < problem.num_segments(); ++s) {
    OutputErrorProblem::Segment segment = problem.segment(s);
    segment.inputs.col(j) =
        (segment.inputs.col(j).array() - level.mean).square() / level.range;
    problem.Respond(segment, point, j, response, /*derivatives=*/false);
    columns.emplace_back(point.values[j].gain * response(segment.times, 0));
  }
  return columns;
}

// Of one element.
struct Evidence {
  double statistic = 0.0;
  int degrees = 0;
  double curvature = 0.0;
};

Evidence TestElement(const OutputSetup& setup, const ShapeLikelihood& null,
                     int j, bool estimate_drift, const NoiseEstimate& noise) {
  const Level level = LevelOf(*setup.problem, j);
  if (!(level.range > 0.0)) return {};
  const Contrast contrast = ContrastWithColumns(
      null, CurvedResponses(*setup.problem, setup.start, j, level),
      estimate_drift, &noise);
  if (contrast.degrees < 1) return {};
  return {.statistic = contrast.statistic,
          .degrees = contrast.degrees,
          .curvature = contrast.coefficients(0)};
}

}  // namespace

double LevelDependence::variation() const { return 2.0 * std::abs(curvature); }

double LevelDependence::LargestVariation() const {
  return 2.0 * (std::abs(curvature) + 2.0 * error);
}

absl::StatusOr<std::vector<LevelDependence>> TestLevelDependence(
    const ProcessModel& model, const std::vector<Record>& records,
    const Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>& fitted,
    const OutputErrorOptions& options,
    const std::vector<NoiseEstimate>& noise) {
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputSetup> setups,
                       SetUpOutputs(model, records, options));
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  std::vector<std::vector<Evidence>> evidence(p, std::vector<Evidence>(m));
  ParallelFor(p, options.threads, [&](int i) {
    const OutputSetup& setup = setups[i];
    if (setup.problem->num_segments() == 0) return;
    AdoptDisturbances(noise[i], *setup.problem);
    std::vector<bool> free(m);
    for (int j = 0; j < m; ++j) free[j] = fitted(i, j) && setup.informed[j];
    const ShapeLikelihood null(*setup.problem, setup.start, free, NoiseShape(),
                               /*restricted=*/true);
    for (int j = 0; j < m; ++j) {
      // Of every output that the input moves, if it has a change anywhere.
      if (!fitted.col(j).any() || !setup.informed[j]) continue;
      evidence[i][j] =
          TestElement(setup, null, j, options.estimate_drift, noise[i]);
    }
  });
  std::vector<LevelDependence> inputs(m);
  for (int j = 0; j < m; ++j) {
    double statistic = 0.0;
    int degrees = 0;
    double precision = 0.0;
    for (int i = 0; i < p; ++i) {
      const Evidence& one = evidence[i][j];
      statistic += one.statistic;
      degrees += one.degrees;
      if (one.curvature == 0.0) continue;
      const double weight = one.statistic / (one.curvature * one.curvature);
      precision += weight;
      inputs[j].curvature += weight * one.curvature;
    }
    if (degrees == 0 || !(precision > 0.0)) continue;
    inputs[j].curvature /= precision;
    inputs[j].error = 1.0 / std::sqrt(precision);
    inputs[j].p_value = ChiSquareTail(statistic, degrees);
  }
  return inputs;
}

}  // namespace mle
