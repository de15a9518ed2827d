#include "apps/experiment/distribution.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "mle/base/double_limits.h"

namespace mle::experiment {
namespace {

constexpr int kResamples = 1000;

double MeanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// `sorted` is ascending.
double Quantile(const std::vector<double>& sorted, double level) {
  const double position = level * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double part = position - static_cast<double>(below);
  // Infinite values stay out of differences.
  if (part == 0.0 || sorted[below] == sorted[above]) return sorted[below];
  if (std::isinf(sorted[above])) return sorted[above];
  return sorted[below] + part * (sorted[above] - sorted[below]);
}

void BootstrapMean(const std::vector<double>& values, std::uint64_t number,
                   Distribution& description) {
  std::mt19937_64 engine(number + 1);
  std::vector<double> means(kResamples);
  const std::uint64_t count = values.size();
  for (double& mean : means) {
    double sum = 0.0;
    for (std::uint64_t i = 0; i < count; ++i) {
      // Uniform to one part in 2⁶⁴/n.
      sum += values[static_cast<std::size_t>(engine() % count)];
    }
    mean = sum / static_cast<double>(count);
  }
  std::sort(means.begin(), means.end());
  description.mean_low = Quantile(means, 0.025);
  description.mean_high = Quantile(means, 0.975);
}

}  // namespace

Distribution Describe(std::vector<double> values, std::uint64_t number) {
  Distribution description;
  description.count = static_cast<int>(values.size());
  if (values.empty()) {
    description.mean = description.mean_low = description.mean_high = kNaN;
    description.deviation = description.min = description.max = kNaN;
    description.quantiles.fill(kNaN);
    return description;
  }
  description.mean = MeanOf(values);
  double squares = 0.0;
  for (const double value : values) {
    squares += (value - description.mean) * (value - description.mean);
  }
  const double count = static_cast<double>(values.size());
  description.deviation = std::isinf(description.mean) ? description.mean
                          : count > 1.0 ? std::sqrt(squares / (count - 1.0))
                                        : 0.0;
  BootstrapMean(values, number, description);
  std::sort(values.begin(), values.end());
  description.min = values.front();
  description.max = values.back();
  for (std::size_t i = 0; i < description.quantiles.size(); ++i) {
    description.quantiles[i] = Quantile(values, Distribution::kLevels[i]);
  }
  return description;
}

}  // namespace mle::experiment
