#include "mle/nonlinear/stamp_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mle/base/double_limits.h"
#include "mle/nonlinear/noise_search.h"

namespace mle {
namespace {

using Eigen::VectorXd;

// Samples of outputs that are measured now and then are as far apart, at least,
// in sample times.
constexpr double kApart = 3.0;
constexpr double kMostStampShare = 0.125;  // s, of the time between samples
constexpr double kLeastStampShare = 0.004;
constexpr double kStep = 1.25;
// The variance of the rest and the weights, in turn.
constexpr int kVarianceRounds = 2;

// Sample times from one measurement to the next, on average.
double DistanceOf(const OutputErrorProblem& problem) {
  double spans = 0.0;
  double steps = 0.0;
  for (int s = 0; s < problem.num_segments(); ++s) {
    const std::vector<int>& times = problem.times(s);
    spans += times.back() - times.front();
    steps += static_cast<double>(times.size()) - 1.0;
  }
  return steps > 0.0 ? spans / steps : 0.0;
}

// The measurements less the simulation, all of whose dead times are longer by
// `by`, at least 0.
VectorXd ResidualsAt(const OutputErrorProblem& problem, const OutputFit& fit,
                     double by) {
  OutputPoint point = fit.point;
  for (ElementValues& values : point.values) {
    values.delay = std::max(values.delay + by, 0.0);
  }
  point.SetCells(problem.sample_time());
  VectorXd residuals(problem.num_samples());
  Eigen::Index begin = 0;
  for (const SegmentColumns& columns :
       problem.Linearise(point, ShapeOf(fit.noise), {})) {
    residuals.segment(begin, columns.residuals.size()) = columns.residuals;
    begin += columns.residuals.size();
  }
  return residuals;
}

// The mean square of what errors of stamps make of each residual `at` 0, by the
// three points of Gauss and Hermite: 0 and, a sixth of the time each, ±√3 s.
VectorXd SquaresBy(const OutputErrorProblem& problem, const OutputFit& fit,
                   const VectorXd& at, double s) {
  const double by = std::sqrt(3.0) * s;
  return ((ResidualsAt(problem, fit, by) - at).cwiseAbs2() +
          (ResidualsAt(problem, fit, -by) - at).cwiseAbs2()) /
         6.0;
}

VectorXd WeightsOf(const VectorXd& squares, double variance) {
  return (1.0 + squares.array() / variance).inverse();
}

}  // namespace

void FindStampNoise(const OutputFit& fit, OutputErrorProblem& problem) {
  problem.SetStampNoise({}, 0.0);
  const double distance = DistanceOf(problem);
  if (distance < kApart || !(fit.noise.variance > 0.0)) return;
  const double time = distance * problem.sample_time();
  const NoiseShape shape = ShapeOf(fit.noise);
  const VectorXd at_zero = ResidualsAt(problem, fit, 0.0);
  // s uniform up to the largest one, integrated on a grid of logarithms.
  struct Possible {
    double deviation = 0.0;
    VectorXd squares;
    double value = 0.0;  // −2 ln L
  };
  std::vector<Possible> all;
  double least = kInfinity;
  double variance = fit.noise.variance;
  for (double share = kLeastStampShare; share <= kMostStampShare;
       share *= kStep) {
    Possible one = {share * time,
                    SquaresBy(problem, fit, at_zero, share * time)};
    for (int round = 0; round < kVarianceRounds; ++round) {
      problem.SetStampNoise(WeightsOf(one.squares, variance), 0.0);
      const Profile at = ShapeLikelihood(problem, fit.point, fit.free, shape,
                                         /*restricted=*/true)
                             .At(shape);
      if (!(at.variance() > 0.0)) return problem.SetStampNoise({}, 0.0);
      variance = at.variance();
      one.value = at.value;
    }
    least = std::min(least, one.value);
    all.push_back(std::move(one));
  }
  double sum = 0.0;
  double mean_square = 0.0;
  VectorXd squares = VectorXd::Zero(problem.num_samples());
  for (const Possible& one : all) {
    const double weight = one.deviation * std::exp(0.5 * (least - one.value));
    sum += weight;
    mean_square += weight * one.deviation * one.deviation;
    squares += weight * one.squares;
  }
  problem.SetStampNoise(WeightsOf(squares / sum, variance),
                        std::sqrt(mean_square / sum));
}

}  // namespace mle
