#include "mle/exchange/nearest_integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace mle {
namespace {

constexpr double kHorizons = 6.0;  // of the slowest time constant
constexpr int kIntegratorSamples = 600;
constexpr int kSplits = 100;  // of L + T

double CoefficientOf(const std::vector<double>& polynomial, std::size_t power) {
  return power < polynomial.size() ? polynomial[polynomial.size() - 1 - power]
                                   : 0.0;
}

}  // namespace

NearestIntegrator NearestIntegrator::Of(const TransferFunction& element) {
  NearestIntegrator nearest;
  nearest.gain = element.StaticGain();
  if (element.IsIntegratorWithLag()) {
    nearest.time_constant = element.TimeConstant();
    nearest.delay = element.delay();
    return nearest;
  }
  // −d/ds ln(s g(s)) at s = 0.
  const std::vector<double>& b = element.numerator();
  const std::vector<double>& a = element.denominator();
  const double begin = std::max(
      0.0, element.delay() + CoefficientOf(a, 2) / CoefficientOf(a, 1) -
               CoefficientOf(b, 1) / CoefficientOf(b, 0));
  const double sample_time =
      (element.delay() + kHorizons * element.SlowestTimeConstant()) /
      (kIntegratorSamples - 1);
  const Eigen::VectorXd response =
      element.StepResponse(sample_time, kIntegratorSamples);
  const double range = response.maxCoeff() - response.minCoeff();
  nearest.largest_difference = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSplits; ++i) {
    const double time_constant = begin * i / kSplits;
    const Eigen::VectorXd difference =
        TransferFunction::Integrator(nearest.gain, time_constant,
                                     begin - time_constant)
            .StepResponse(sample_time, kIntegratorSamples) -
        response;
    const double largest = difference.cwiseAbs().maxCoeff() / range;
    if (largest >= nearest.largest_difference) continue;
    nearest.largest_difference = largest;
    nearest.relative_rms =
        std::sqrt(difference.squaredNorm() / kIntegratorSamples) / range;
    nearest.time_constant = time_constant;
    nearest.delay = begin - time_constant;
  }
  return nearest;
}

}  // namespace mle
