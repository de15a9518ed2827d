#include "mle/data/steady_operation.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace mle {
namespace {

constexpr int kMinSteadySamples = 20;
constexpr int kMinSide = 5;  // samples on each side of a step
constexpr double kOutlierDeviations = 6.0;

// A trend or a step fitted to the samples.
struct Explanation {
  double size = 0.0;
  double squares = 0.0;  // by which it lowers the sum of squares
  int at = 0;            // of the step: the first sample after
};

Explanation FitTrend(const std::vector<int>& times,
                     const std::vector<double>& values) {
  const double n = static_cast<double>(times.size());
  double mean_time = 0.0;
  for (const int time : times) mean_time += time / n;
  double squares = 0.0;
  double product = 0.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double t = times[k] - mean_time;
    squares += t * t;
    product += t * values[k];
  }
  Explanation trend;
  trend.size = product / squares * (times.back() - times.front());
  trend.squares = product * product / squares;
  return trend;
}

// `values` have mean 0.
Explanation FitStep(const std::vector<double>& values) {
  const int n = static_cast<int>(values.size());
  Explanation step;
  double sum = 0.0;
  for (int k = 0; k < n; ++k) {
    if (k >= kMinSide && n - k >= kMinSide) {
      const double left = k;
      const double right = n - k;
      const double squares = sum * sum * (1.0 / left + 1.0 / right);
      if (squares > step.squares) {
        step.squares = squares;
        step.size = -sum / right - sum / left;
        step.at = k;
      }
    }
    sum += values[k];
  }
  return step;
}

}  // namespace

SteadyOperation TestSteadyOperation(const SampleRow& samples, double start_time,
                                    double sample_time, SteadyLimits limits) {
  SteadyOperation part;
  part.noise = WhiteDeviation(samples);
  int used = 0;
  const double center = TrimmedMean(samples, used);
  const double limit = kOutlierDeviations * RobustDeviation(samples);
  std::vector<int> times;
  std::vector<double> values;
  for (Eigen::Index k = 0; k < samples.size(); ++k) {
    const double value = samples(k) - center;
    if (!std::isfinite(value) || (limit > 0.0 && std::abs(value) > limit)) {
      continue;
    }
    times.push_back(static_cast<int>(k));
    values.push_back(value);
  }
  if (static_cast<int>(times.size()) < kMinSteadySamples) return part;
  double mean = 0.0;
  for (const double value : values) mean += value;
  mean /= static_cast<double>(values.size());
  for (double& value : values) value -= mean;

  const Explanation trend = FitTrend(times, values);
  const Explanation step = FitStep(values);
  const bool is_step = step.squares > trend.squares;
  const Explanation& best = is_step ? step : trend;
  // A constant signal has no noise to compare with, and nothing to find.
  const double scale = std::max(std::abs(center), limit);
  const double noise = std::max(part.noise, 1e-12 * scale);
  part.size = best.size;
  part.deviations = noise > 0.0 ? std::sqrt(best.squares) / noise : 0.0;
  part.verdict = SteadyOperation::Verdict::kSteady;
  if (part.deviations > limits.deviations &&
      std::abs(part.size) > limits.size * noise) {
    part.verdict = is_step ? SteadyOperation::Verdict::kDisturbed
                           : SteadyOperation::Verdict::kDrifting;
    if (is_step) part.time = start_time + sample_time * times[step.at];
  }
  return part;
}

}  // namespace mle
