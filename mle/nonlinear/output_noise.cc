#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

using Eigen::MatrixXd;

constexpr double kCurvatureStep = 0.3;
constexpr double kMaxLogDeviation = 3.0;

std::array<double, kShapeParameters> LogDeviations(
    const ShapeLikelihood& likelihood, const Profile& best) {
  std::array<double, kShapeParameters> deviations = {};
  for (int i = 0; i < kShapeParameters; ++i) {
    if (!HasParameter(best.shape, i)) continue;
    const auto moved = [&](double by) {
      return likelihood.At(Moved(best.shape, i, by)).value;
    };
    const double curvature =
        (moved(kCurvatureStep) + moved(-kCurvatureStep) - 2.0 * best.value) /
        (kCurvatureStep * kCurvatureStep);
    // A flat likelihood says little, but not nothing: the range is finite.
    deviations[i] =
        std::min(std::sqrt(2.0 / std::max(curvature, 1e-3)), kMaxLogDeviation);
  }
  return deviations;
}

}  // namespace

NoiseEstimate NoiseOf(const ShapeLikelihood& likelihood,
                      const Profile& profile) {
  NoiseEstimate noise;
  noise.variance = profile.variance();
  noise.ratio = profile.shape.ratio;
  noise.offset = profile.shape.offset;
  noise.ar_ratio = profile.shape.ar_ratio;
  noise.ar_pole = profile.shape.ar_pole;
  noise.ar_damping = profile.shape.ar_damping;
  noise.log_deviations = LogDeviations(likelihood, profile);
  return noise;
}

NoiseEstimate EstimateNoise(const OutputErrorProblem& problem,
                            const OutputPoint& point,
                            const std::vector<bool>& free,
                            const NoiseEstimate& start, bool estimate_drift,
                            bool search_ar) {
  const ShapeLikelihood likelihood(problem, point, free, ShapeOf(start),
                                   /*restricted=*/true);
  return NoiseOf(likelihood, start.offset
                                 ? FindBestShape(likelihood, ShapeOf(start),
                                                 estimate_drift, search_ar)
                                 : likelihood.At(ShapeOf(start)));
}

OffsetEvidence FindOffsetEvidence(const OutputErrorProblem& problem,
                                  const OutputPoint& point,
                                  const std::vector<bool>& free,
                                  const NoiseEstimate& noise,
                                  bool estimate_drift) {
  const ShapeLikelihood likelihood(problem, point, free, ShapeOf(noise),
                                   /*restricted=*/true);
  const Profile with = likelihood.At(NoiseShape());
  const Profile without = likelihood.At({.ratio = 0.0, .offset = false});
  OffsetEvidence evidence;
  evidence.offsets = (without.squares - with.squares) / with.variance();
  if (problem.num_segments() > 0) {
    evidence.num_parameters = problem.num_segments() + (estimate_drift ? 1 : 0);
  }
  for (int i = 1; i < kShapeParameters; ++i) {
    evidence.num_parameters += HasParameter(ShapeOf(noise), i) ? 1 : 0;
  }
  if (noise.ratio > 0.0 || noise.ar_ratio > 0.0) {
    evidence.drift = with.value - likelihood.At(ShapeOf(noise)).value;
  }
  return evidence;
}

double OffsetWeight(const std::vector<OffsetEvidence>& evidence) {
  double excess = 0.0;  // of AIC without over AIC with
  for (const OffsetEvidence& e : evidence) {
    excess += std::max(e.offsets, 0.0) + std::max(e.drift, 0.0) -
              2.0 * e.num_parameters;
  }
  return 1.0 / (1.0 + std::exp(-0.5 * excess));
}

double Deviance(const OutputErrorProblem& problem, const OutputPoint& point,
                const std::vector<bool>& free, const NoiseEstimate& start,
                bool estimate_drift) {
  const ShapeLikelihood likelihood(problem, point, free, ShapeOf(start),
                                   /*restricted=*/false);
  if (!start.offset) return likelihood.At(ShapeOf(start)).value;
  return FindBestShape(likelihood, ShapeOf(start), estimate_drift,
                       /*search_ar=*/false)
      .value;
}

namespace {

// Both under `shape`, that of the alternative, and every ρ that is possible for
// it: the null's own shape would hold the error of its model, and excuse it.
// The sum is the ratio of likelihoods integrated over ρ on both sides, with
// the weights of the intervals (IntegrateRatio), so that test and intervals
// agree. At the best ρ alone weak drift, of which the best estimate is often 0,
// would raise false alarms.
Contrast OverRatios(const ShapeLikelihood& null,
                    const ShapeLikelihood& alternative, NoiseShape shape,
                    bool estimate_drift) {
  const OutputErrorProblem& problem = alternative.problem();
  std::vector<PossibleRatio> ratios = {{shape.ratio, 1.0}};
  if (estimate_drift && problem.num_segments() > 0) {
    ratios = PossibleRatios(problem);
  }
  std::vector<Profile> profiles;
  double best = -std::numeric_limits<double>::infinity();
  for (const PossibleRatio& possible : ratios) {
    shape.ratio = possible.ratio;
    profiles.push_back(alternative.At(shape));
    best =
        std::max(best, std::log(possible.prior) - 0.5 * profiles.back().value);
  }
  Contrast contrast;
  double total = 0.0;
  double excused = 0.0;
  double least = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, double>> parts;  // weight and S
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    const Profile& with = profiles[i];
    const double weight =
        std::exp(std::log(ratios[i].prior) - 0.5 * with.value - best);
    if (!(weight > kSmallWeight)) continue;
    const Profile without = null.At(with.shape);
    const double reduction =
        std::max(without.squares - with.squares, 0.0) / with.variance();
    contrast.degrees = with.rank - without.rank;
    parts.emplace_back(weight, reduction);
    least = std::min(least, reduction);
    total += weight;
  }
  for (const auto& [weight, reduction] : parts) {
    excused += weight / total * std::exp(-0.5 * (reduction - least));
  }
  contrast.statistic = least - 2.0 * std::log(excused);
  return contrast;
}

}  // namespace

Contrast ContrastWithColumns(const ShapeLikelihood& null,
                             const std::vector<MatrixXd>& columns,
                             bool estimate_drift) {
  const ShapeLikelihood alternative = null.With(columns);
  Profile with = FindBestShape(alternative, NoiseShape(), estimate_drift,
                               /*search_ar=*/true);
  const double of_null = FindBestShape(null, with.shape, estimate_drift,
                                       /*search_ar=*/false)
                             .shape.ratio;
  if (of_null > with.shape.ratio) {
    NoiseShape shape = with.shape;
    shape.ratio = of_null;
    with = alternative.At(shape);
  }
  const Profile without = null.At(with.shape);
  return {.statistic =
              std::max(without.squares - with.squares, 0.0) / with.variance(),
          .degrees = with.rank - without.rank};
}

Contrast ContrastWithFit(const OutputErrorProblem& problem,
                         const OutputPoint& null, const OutputPoint& point,
                         const std::vector<bool>& free,
                         const NoiseEstimate& noise, bool estimate_drift) {
  const NoiseShape shape = ShapeOf(noise);
  return OverRatios(
      ShapeLikelihood(problem, null, std::vector<bool>(free.size(), false),
                      shape, /*restricted=*/true),
      ShapeLikelihood(problem, point, free, shape, /*restricted=*/true), shape,
      estimate_drift);
}

}  // namespace mle
