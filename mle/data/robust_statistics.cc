#include "mle/data/robust_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mle {
namespace {

constexpr std::size_t kMaxDifferences = 20000;
constexpr std::size_t kMinDifferences = 50;
constexpr double kStepTolerance = 0.03;  // of a step
// Bridged and averaged samples lie between steps.
constexpr double kMinShare = 0.85;
constexpr double kWorthNaming = 0.02;
constexpr double kStepRounding = 1e-9;

// The share of `differences` (sorted) that are multiples of `step`.
double ShareOfMultiples(const std::vector<double>& differences, double step) {
  double count = 0.0;
  for (const double difference : differences) {
    const double multiple = difference / step;
    if (std::abs(multiple - std::round(multiple)) <= kStepTolerance &&
        multiple > 0.5) {
      count += 1.0;
    }
  }
  return count / static_cast<double>(differences.size());
}

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

double FindQuantum(const std::vector<SampleRow>& rows, double noise) {
  std::vector<double> differences;
  double largest = 0.0;
  for (const SampleRow& row : rows) {
    for (Eigen::Index k = 1; k < row.size(); ++k) {
      if (!std::isfinite(row(k)) || !std::isfinite(row(k - 1))) continue;
      largest = std::max(largest, std::abs(row(k)));
      const double difference = std::abs(row(k) - row(k - 1));
      if (difference > kStepRounding * largest &&
          differences.size() < kMaxDifferences) {
        differences.push_back(difference);
      }
    }
  }
  if (differences.size() < kMinDifferences) return 0.0;
  std::sort(differences.begin(), differences.end());
  const double usual =
      noise > 0.0 ? noise : differences[differences.size() / 2];
  double quantum = 0.0;
  for (const double quantile : {0.0, 0.01, 0.02, 0.05, 0.1, 0.2}) {
    const auto at = static_cast<std::size_t>(
        quantile * static_cast<double>(differences.size() - 1));
    const double step = differences[at];
    if (step > quantum && step >= kWorthNaming * usual &&
        ShareOfMultiples(differences, step) >= kMinShare) {
      quantum = step;
    }
  }
  return quantum;
}

}  // namespace mle
