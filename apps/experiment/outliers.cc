#include "apps/experiment/outliers.h"

#include <cmath>
#include <random>

namespace mle::experiment {
namespace {

constexpr double kSmallest = 10.0;  // standard deviations
constexpr double kLargest = 50.0;

}  // namespace

void AddOutliers(const WindowSpec& spec, double noise_variance,
                 std::uint64_t seed, std::vector<Record>& windows) {
  if (!(spec.outlier_share > 0.0)) return;
  const double deviation = std::sqrt(noise_variance);
  const int longest = spec.longest_outlier;
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> size(kSmallest, kLargest);
  for (Record& window : windows) {
    const int samples = window.samples();
    for (int i = 0; i < window.num_outputs(); ++i) {
      for (int changed = 0; changed < spec.outlier_share * samples;) {
        const int length =
            longest == 1 ? 1
                         : std::uniform_int_distribution<int>(
                               WindowSpec::kShortestBurst, longest)(engine);
        const int first =
            std::uniform_int_distribution<int>(0, samples - length)(engine);
        const double side = engine() % 2 == 0 ? 1.0 : -1.0;
        for (int k = first; k < first + length; ++k) {
          window.outputs(i, k) += side * size(engine) * deviation;
        }
        changed += length;
      }
    }
  }
}

OutputErrorOptions OutputErrorOptionsFor(OutlierTreatment treatment) {
  OutputErrorOptions options;
  if (treatment == OutlierTreatment::kHuber) {
    options.robust_loss = RobustLoss::kHuber;
  } else if (treatment == OutlierTreatment::kCauchy) {
    options.robust_loss = RobustLoss::kCauchy;
  }
  return options;
}

}  // namespace mle::experiment
