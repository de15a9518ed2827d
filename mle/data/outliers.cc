#include "mle/data/outliers.h"

#include <algorithm>
#include <cmath>

namespace mle {
namespace {

constexpr double kLocal = 0.8;
// A distance up to this share of the largest sample may be rounding.
constexpr double kSampleRounding = 1e-9;

// Whether the median of samples first … last may be farther than `distance`
// from sample k: half of them have to be, on one side. Most samples end here.
bool IsCandidate(const SampleRow& samples, int k, int first, int last,
                 double distance) {
  const double low = samples(k) - distance;
  const double high = samples(k) + distance;
  int good = 0;
  int below = 0;
  int above = 0;
  for (int i = first; i <= last; ++i) {
    good += std::isfinite(samples(i)) ? 1 : 0;
    below += samples(i) < low ? 1 : 0;
    above += samples(i) > high ? 1 : 0;
  }
  return 2 * std::max(below, above) >= good;
}

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
    if (!IsCandidate(samples, k, first, last, options.threshold * noise)) {
      continue;
    }
    around.clear();
    for (int i = first; i <= last; ++i) {
      if (std::isfinite(samples(i))) around.push_back(samples(i));
    }
    if (static_cast<int>(around.size()) <= options.half_width) continue;
    const double median = MedianInPlace(around);
    const double distance = std::abs(samples(k) - median);
    if (distance <= options.threshold * noise ||
        distance <= kSampleRounding * largest) {
      continue;
    }
    for (double& value : around) value = std::abs(value - median);
    const double spread = kGaussianDeviation * MedianInPlace(around);
    if (distance > kLocal * options.threshold * spread) outliers.push_back(k);
  }
  return outliers;
}

}  // namespace mle
