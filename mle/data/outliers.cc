#include "mle/data/outliers.h"

#include <algorithm>
#include <cmath>

namespace mle {
namespace {

constexpr double kGaussian = 1.4826;
constexpr double kLocal = 0.8;
// Of the largest sample: what rounding can do.
constexpr double kRounding = 1e-9;

}  // namespace

std::vector<int> FindOutliers(const SampleRow& samples,
                              const OutlierOptions& options) {
  std::vector<int> outliers;
  const int n = static_cast<int>(samples.size());
  const double noise = WhiteDeviation(samples);
  double largest = 0.0;
  for (const double sample : samples) {
    if (std::isfinite(sample)) largest = std::max(largest, std::abs(sample));
  }
  std::vector<double> around;
  for (int k = 0; k < n; ++k) {
    if (!std::isfinite(samples(k))) continue;
    const int first = std::max(0, k - options.half_width);
    const int last = std::min(n - 1, k + options.half_width);
    around.clear();
    for (int i = first; i <= last; ++i) {
      if (std::isfinite(samples(i))) around.push_back(samples(i));
    }
    if (static_cast<int>(around.size()) <= options.half_width) continue;
    const double median = MedianInPlace(around);
    const double distance = std::abs(samples(k) - median);
    // Most samples are no candidates; the rest is for those that are.
    if (distance <= options.threshold * noise ||
        distance <= kRounding * largest) {
      continue;
    }
    for (double& value : around) value = std::abs(value - median);
    const double spread = kGaussian * MedianInPlace(around);
    if (distance > kLocal * options.threshold * spread) outliers.push_back(k);
  }
  return outliers;
}

}  // namespace mle
