#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The fit to first order under a ratio of drift.
struct AtRatio {
  MatrixXd products;  // of the derivatives, then the residuals
  Profile profile;
};

AtRatio ProductsAtRatio(const ShapeLikelihood& likelihood, const OutputFit& fit,
                        double ratio) {
  NoiseShape shape = ShapeOf(fit.noise);
  shape.ratio = ratio;
  ShapedProducts shaped = likelihood.ProductsAt(shape);
  Profile profile = likelihood.ProfileOf(shape, shaped);
  return {std::move(shaped.products), std::move(profile)};
}

LinearEstimate EstimateAt(const OutputErrorProblem& problem,
                          const OutputFit& fit, const AtRatio& at) {
  const MatrixXd& products = at.products;
  const double variance = at.profile.variance();
  const Eigen::Index width = products.cols() - 1;
  // (JᵀV⁻¹J)⁻¹ r⁻¹ in units of K, T and L: r may be too small a number to
  // divide by.
  MatrixXd inverse =
      CovarianceOf(problem, products, fit.point, fit.free, 1.0).covariance;
  LinearEstimate estimate;
  estimate.covariance = variance * inverse;
  // A step of Gauss and Newton.
  VectorXd gradient = VectorXd::Zero(inverse.rows());
  gradient(FreeParameters(fit.free)) = products.col(width).head(width);
  for (std::size_t j = 0; j < fit.free.size(); ++j) {
    const auto t = 3 * static_cast<Eigen::Index>(j) + 1;
    if (fit.free[j]) gradient(t) /= fit.point.values[j].time_scale;
  }
  for (Eigen::Index i = 0; i < inverse.rows(); ++i) {
    if (!std::isfinite(inverse(i, i))) {
      inverse.row(i).setZero();
      inverse.col(i).setZero();
    }
  }
  estimate.change = -inverse * gradient;
  // Numbers at the ends of their range give no step.
  if (!estimate.change.allFinite()) estimate.change.setZero();
  return estimate;
}

}  // namespace

std::vector<LinearEstimate> IntegrateRatio(const OutputErrorProblem& problem,
                                           const OutputFit& fit,
                                           bool estimate_drift) {
  const bool any =
      std::find(fit.free.begin(), fit.free.end(), true) != fit.free.end();
  const LinearEstimate itself = {
      .weight = 1.0,
      .change = VectorXd::Zero(fit.covariance.rows()),
      .covariance = fit.covariance,
      .degrees_of_freedom = fit.degrees_of_freedom};
  if (!estimate_drift || !any || problem.num_segments() == 0) return {itself};
  const ShapeLikelihood likelihood(
      problem, LineariseWidely(problem, fit.point, fit.free, fit.noise),
      fit.free, /*restricted=*/true);
  const VectorXd at_fit =
      EstimateAt(problem, fit,
                 ProductsAtRatio(likelihood, fit, fit.noise.ratio))
          .change;
  // Probabilities but for a factor, as logarithms.
  const std::vector<PossibleRatio> ratios = PossibleRatios(problem);
  std::vector<AtRatio> at_ratios;
  std::vector<double> log_probabilities;
  double best = -std::numeric_limits<double>::infinity();
  for (const PossibleRatio& possible : ratios) {
    at_ratios.push_back(ProductsAtRatio(likelihood, fit, possible.ratio));
    log_probabilities.push_back(std::log(possible.prior) -
                                0.5 * at_ratios.back().profile.value);
    best = std::max(best, log_probabilities.back());
  }
  double total = 0.0;
  std::vector<LinearEstimate> estimates;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    const double weight = std::exp(log_probabilities[i] - best);
    if (!(weight > kSmallWeight)) continue;
    LinearEstimate& estimate =
        estimates.emplace_back(EstimateAt(problem, fit, at_ratios[i]));
    estimate.weight = weight;
    total += weight;
    // The gradient that is left at the fit (kinks and bounds) gives no step.
    estimate.change -= at_fit;
    estimate.covariance = fit.inflation.Scale(estimate.covariance);
  }
  // No likelihood is a number.
  if (estimates.empty()) return {itself};
  for (LinearEstimate& estimate : estimates) {
    estimate.weight /= total;
    // Degrees of freedom of r: what is not known of ρ is in the weights.
    estimate.degrees_of_freedom = VectorXd::Constant(
        fit.covariance.rows(), problem.num_innovations(NoiseShape()));
  }
  return estimates;
}

}  // namespace mle
