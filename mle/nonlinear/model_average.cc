#include "mle/nonlinear/model_average.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "Eigen/Cholesky"
#include "boost/math/tools/toms748_solve.hpp"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Component {
  double weight;
  double value;
  double error;
  double degrees;
};

// Probability of a parameter above x.
double Tail(const std::vector<Component>& components, double x) {
  double tail = 0.0;
  for (const Component& c : components) {
    tail += c.weight * StudentTail((x - c.value) / c.error, c.degrees);
  }
  return tail;
}

// The x above which it lies with `probability`, between bounds.
double Quantile(const std::vector<Component>& components, double probability,
                double low, double high) {
  const auto excess = [&](double x) {
    return Tail(components, x) - probability;
  };
  const double at_low = excess(low);
  const double at_high = excess(high);
  if (!(at_low > 0.0)) return low;
  if (!(at_high < 0.0)) return high;
  std::uintmax_t evaluations = 200;
  const auto [below, above] = boost::math::tools::toms748_solve(
      excess, low, high, at_low, at_high,
      boost::math::tools::eps_tolerance<double>(44), evaluations);
  return 0.5 * (below + above);
}

// 1/(C⁻¹)_ii, of what is fitted and determined; C_ii where rounding leaves no
// inverse.
double VarianceGivenOthers(const MatrixXd& covariance, int index) {
  const double variance = covariance(index, index);
  if (!(variance > 0.0) || !std::isfinite(variance)) return variance;
  std::vector<Eigen::Index> kept;
  Eigen::Index place = 0;
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    if (k == index) place = static_cast<Eigen::Index>(kept.size());
    const double own = covariance(k, k);
    if (own > 0.0 && std::isfinite(own)) kept.push_back(k);
  }
  const VectorXd scale = covariance.diagonal()(kept).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<MatrixXd> factors(
      scale.asDiagonal() * covariance(kept, kept) * scale.asDiagonal());
  const VectorXd unit = VectorXd::Unit(scale.size(), place);
  const double precision = factors.solve(unit)(place);
  return factors.isPositive() && precision >= 1.0 ? variance / precision
                                                  : variance;
}

}  // namespace

VectorXd ParametersOf(const OutputPoint& point) {
  VectorXd parameters(3 * static_cast<Eigen::Index>(point.values.size()));
  for (std::size_t j = 0; j < point.values.size(); ++j) {
    const ElementValues& v = point.values[j];
    parameters.segment(3 * static_cast<Eigen::Index>(j), 3) << v.gain,
        v.time_scale, v.delay;
  }
  return parameters;
}

OutputFit Average(const std::vector<WeightedFit>& fits, double sample_time) {
  CHECK(!fits.empty());
  const WeightedFit& heaviest = *std::max_element(
      fits.begin(), fits.end(),
      [](const auto& a, const auto& b) { return a.weight < b.weight; });
  OutputFit average = *heaviest.fit;
  if (fits.size() == 1) return average;
  // As differences from the heaviest: what is held does not differ at all.
  const VectorXd base = ParametersOf(average.point);
  VectorXd shift = VectorXd::Zero(base.size());
  VectorXd inverse_degrees = VectorXd::Zero(base.size());
  for (const WeightedFit& part : fits) {
    shift += part.weight * (ParametersOf(part.fit->point) - base);
    inverse_degrees +=
        part.weight * part.fit->degrees_of_freedom.cwiseInverse();
    average.certificate.search_confirmed &=
        part.fit->certificate.search_confirmed;
    average.certificate.gradient =
        std::max(average.certificate.gradient, part.fit->certificate.gradient);
  }
  average.covariance.setZero();
  for (const WeightedFit& part : fits) {
    const VectorXd apart = ParametersOf(part.fit->point) - base - shift;
    average.covariance +=
        part.weight * (part.fit->covariance + apart * apart.transpose());
  }
  average.degrees_of_freedom = inverse_degrees.cwiseInverse();
  const VectorXd mean = base + shift;
  for (std::size_t j = 0; j < average.free.size(); ++j) {
    if (!average.free[j]) continue;
    const auto values = mean.segment(3 * static_cast<Eigen::Index>(j), 3);
    average.point.values[j] = {values(0), values(1), values(2)};
  }
  average.point.SetCells(sample_time);
  return average;
}

Interval MixtureInterval(const std::vector<WeightedFit>& fits, int index,
                         double confidence) {
  std::vector<Component> components;
  Interval widest = {kInfinity, -kInfinity};
  for (const WeightedFit& part : fits) {
    const double value = ParametersOf(part.fit->point)(index);
    const double variance = part.fit->covariance(index, index);
    const double degrees = part.fit->degrees_of_freedom(index);
    if (!std::isfinite(variance)) return {-kInfinity, kInfinity};
    const double error = std::sqrt(variance);
    const double half =
        variance > 0.0
            ? StudentTwoSidedQuantile(1.0 - confidence, degrees) * error
            : 0.0;
    widest.low = std::min(widest.low, value - half);
    widest.high = std::max(widest.high, value + half);
    if (variance > 0.0) {
      components.push_back({part.weight, value, error, degrees});
    }
  }
  // One fit, or nothing to mix.
  if (components.size() < 2) return widest;
  const double tail = 0.5 * (1.0 - confidence);
  return {Quantile(components, 1.0 - tail, widest.low, widest.high),
          Quantile(components, tail, widest.low, widest.high)};
}

double DetectableChange(const std::vector<WeightedFit>& fits, int index,
                        double statistic) {
  std::vector<double> variances;
  for (const WeightedFit& part : fits) {
    variances.push_back(VarianceGivenOthers(part.fit->covariance, index));
  }
  const double widest = *std::max_element(variances.begin(), variances.end());
  if (!std::isfinite(widest)) return kInfinity;
  double low = 0.0;
  double high = std::sqrt(statistic * widest);  // of the widest part alone
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    double sum = 0.0;
    for (std::size_t a = 0; a < fits.size(); ++a) {
      sum += fits[a].weight *
             std::exp(-0.5 * middle * middle / std::max(variances[a], 1e-300));
    }
    (sum > std::exp(-0.5 * statistic) ? low : high) = middle;
  }
  return high;
}

void Mixture::Add(double weight, OutputFit fit) {
  weights.push_back(weight);
  fits.push_back(std::move(fit));
}

void Mixture::AddShifted(double weight, const OutputFit& fit,
                         std::vector<LinearEstimate> estimates,
                         const OutputFitBounds& bounds) {
  for (LinearEstimate& estimate : estimates) {
    OutputFit shifted = fit;
    for (std::size_t j = 0; j < fit.free.size(); ++j) {
      if (!fit.free[j]) continue;
      const auto k = 3 * static_cast<Eigen::Index>(j);
      ElementValues& v = shifted.point.values[j];
      v.gain += estimate.change(k);
      v.time_scale =
          std::clamp(v.time_scale + estimate.change(k + 1),
                     bounds.min_time_scales[j], bounds.max_time_scales[j]);
      v.delay = std::clamp(v.delay + estimate.change(k + 2), 0.0,
                           std::max(bounds.max_delays[j], v.delay));
    }
    shifted.covariance = std::move(estimate.covariance);
    shifted.degrees_of_freedom = std::move(estimate.degrees_of_freedom);
    Add(weight * estimate.weight, std::move(shifted));
  }
}

std::vector<WeightedFit> Mixture::parts() const {
  std::vector<WeightedFit> parts;
  for (std::size_t k = 0; k < fits.size(); ++k) {
    parts.push_back({weights[k], &fits[k]});
  }
  return parts;
}

}  // namespace mle
