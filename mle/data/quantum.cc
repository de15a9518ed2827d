#include "mle/data/quantum.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

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
