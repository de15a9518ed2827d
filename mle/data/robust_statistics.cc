#include "mle/data/robust_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mle {
namespace {

constexpr double kTrimDeviations = 6.0;

std::vector<double> Finite(const SampleRow& samples) {
  std::vector<double> values;
  values.reserve(samples.size());
  for (const double sample : samples) {
    if (std::isfinite(sample)) values.push_back(sample);
  }
  return values;
}

double DeviationFrom(double center, std::vector<double>& values) {
  for (double& value : values) value = std::abs(value - center);
  return kGaussianDeviation * MedianInPlace(values);
}

}  // namespace

double MedianInPlace(std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double RobustDeviation(const SampleRow& samples) {
  std::vector<double> values = Finite(samples);
  if (values.size() < 2) return 0.0;
  const double center = MedianInPlace(values);
  return DeviationFrom(center, values);
}

double WhiteDeviation(const SampleRow& samples) {
  std::vector<double> steps;
  for (Eigen::Index k = 1; k < samples.size(); ++k) {
    const double step = samples(k) - samples(k - 1);
    if (std::isfinite(step)) steps.push_back(step);
  }
  if (steps.empty()) return 0.0;
  for (double& step : steps) step = std::abs(step);
  const double median = MedianInPlace(steps);
  if (median > 0.0) return kGaussianDeviation * median / std::sqrt(2.0);
  // Rounding makes most neighbours equal: their mean square then, without the
  // largest hundredth.
  std::sort(steps.begin(), steps.end());
  steps.resize(steps.size() - steps.size() / 100);
  double squares = 0.0;
  for (const double step : steps) squares += step * step;
  return std::sqrt(squares / (2.0 * static_cast<double>(steps.size())));
}

double TrimmedMean(const SampleRow& samples, int& used) {
  used = 0;
  std::vector<double> values = Finite(samples);
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double center = MedianInPlace(values);
  std::vector<double> distances = values;
  const double limit = kTrimDeviations * DeviationFrom(center, distances);
  double sum = 0.0;
  for (const double value : values) {
    // About the centre, so that equal values have exactly their own mean.
    if (std::abs(value - center) > limit && limit > 0.0) continue;
    sum += value - center;
    ++used;
  }
  return center + sum / used;
}

}  // namespace mle
