#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The probability of a ratio but for a factor, and the estimates under it.
struct Candidate {
  double log_probability = 0.0;
  LinearEstimate estimate;
};

Candidate AtRatio(const OutputErrorProblem& problem, const OutputFit& fit,
                  const std::vector<SegmentColumns>& columns, double ratio,
                  double prior) {
  NoiseShape shape = ShapeOf(fit.noise);
  shape.ratio = ratio;
  const RatioLikelihood likelihood =
      RestrictedLikelihood(problem, fit.free, columns, shape);
  const WhitenedColumns whitened = problem.Whiten(columns, shape);
  Candidate candidate;
  candidate.log_probability = std::log(prior) - 0.5 * likelihood.deviance;
  candidate.estimate.covariance =
      CovarianceOf(whitened, fit.point, fit.free, likelihood.variance)
          .covariance;
  // A step of Gauss and Newton, V Jᵀ(−r)/r with V/r in units of K, T and L.
  VectorXd gradient = whitened.jacobian.transpose() * whitened.residuals;
  for (std::size_t j = 0; j < fit.free.size(); ++j) {
    const auto t = 3 * static_cast<Eigen::Index>(j) + 1;
    if (fit.free[j]) gradient(t) /= fit.point.values[j].time_scale;
  }
  MatrixXd finite = candidate.estimate.covariance;
  for (Eigen::Index i = 0; i < finite.rows(); ++i) {
    if (!std::isfinite(finite(i, i))) {
      finite.row(i).setZero();
      finite.col(i).setZero();
    }
  }
  candidate.estimate.change = -finite * gradient / likelihood.variance;
  return candidate;
}

}  // namespace

std::vector<LinearEstimate> IntegrateRatio(const OutputErrorProblem& problem,
                                           const OutputFit& fit,
                                           bool estimate_drift) {
  const bool any =
      std::find(fit.free.begin(), fit.free.end(), true) != fit.free.end();
  if (!estimate_drift || !any || problem.num_segments() == 0) {
    return {{.weight = 1.0,
             .change = VectorXd::Zero(fit.covariance.rows()),
             .covariance = fit.covariance,
             .degrees_of_freedom = fit.degrees_of_freedom}};
  }
  const std::vector<SegmentColumns> columns =
      LineariseWidely(problem, fit.point, fit.free, fit.noise);
  const VectorXd at_fit =
      AtRatio(problem, fit, columns, fit.noise.ratio, 1.0).estimate.change;
  std::vector<Candidate> candidates;
  for (const PossibleRatio& possible : PossibleRatios(problem)) {
    candidates.push_back(
        AtRatio(problem, fit, columns, possible.ratio, possible.prior));
  }
  double best = -std::numeric_limits<double>::infinity();
  for (const Candidate& c : candidates)
    best = std::max(best, c.log_probability);
  double total = 0.0;
  std::vector<LinearEstimate> estimates;
  for (Candidate& c : candidates) {
    c.estimate.weight = std::exp(c.log_probability - best);
    if (!(c.estimate.weight > kSmallWeight)) continue;
    total += c.estimate.weight;
    // What is left of the gradient at the fit (kinks and bounds) stays.
    c.estimate.change -= at_fit;
    c.estimate.covariance = fit.inflation.Scale(c.estimate.covariance);
    estimates.push_back(std::move(c.estimate));
  }
  for (LinearEstimate& estimate : estimates) {
    estimate.weight /= total;
    // Of r: what is not known of ρ is in the weights.
    estimate.degrees_of_freedom = VectorXd::Constant(
        fit.covariance.rows(), problem.num_innovations(NoiseShape()));
  }
  return estimates;
}

}  // namespace mle
