#include "mle/data/sampling.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "mle/base/number_range.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/robust_statistics.h"

namespace mle {
namespace {

constexpr double kMaxSamples = 1e9;

}  // namespace

absl::Status ValidateSampling(double sample_time, double duration) {
  MLE_RETURN_IF_ERROR(ValidateSampleTime("sample_time", sample_time));
  if (!(duration > 0.0) || !std::isfinite(duration)) {
    return InvalidArgument("duration = ", duration,
                           ", but it must be finite and > 0");
  }
  if (duration / sample_time >= kMaxSamples) {
    return InvalidArgument(
        "duration = ", duration,
        " has too many samples of sample_time = ", sample_time, "; at most ",
        kMaxSamples, " are supported");
  }
  return absl::OkStatus();
}

absl::Status ValidateNoiseVariance(double noise_variance) {
  if (!(noise_variance >= 0.0) || !std::isfinite(noise_variance)) {
    return InvalidArgument("noise_variance = ", noise_variance,
                           ", but it must be finite and ≥ 0");
  }
  return absl::OkStatus();
}

int SampleCount(double sample_time, double duration) {
  return static_cast<int>(std::floor(duration / sample_time + 1e-6)) + 1;
}

int MeasuredEvery(const std::vector<Record>& records, int output) {
  std::vector<int> distances;
  for (const Record& record : records) {
    int last = -1;
    for (int k = 0; k < record.samples(); ++k) {
      if (!std::isfinite(record.outputs(output, k))) continue;
      if (last >= 0) distances.push_back(k - last);
      last = k;
    }
  }
  if (distances.empty()) return 0;
  const auto middle =
      distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

double UsualStep(const std::vector<double>& steps) {
  std::vector<double> sorted = steps;
  const double median = MedianInPlace(sorted);
  double sum = 0.0;
  double count = 0.0;
  double spread = 0.0;
  for (const double step : steps) {
    if (std::abs(step - median) > 0.1 * median) continue;
    sum += step;
    spread += std::abs(step - median);
    count += 1.0;
  }
  const double mean = count > 0.0 ? sum / count : median;
  // Uneven rows have no step that is exact.
  const bool is_uneven = count < 0.5 * static_cast<double>(steps.size()) ||
                         spread > 0.005 * median * count;
  const double tolerance = is_uneven ? 5e-3 : 1e-6;
  for (int digits = 1; digits <= kCsvTimeDigits; ++digits) {
    const double scale =
        std::pow(10.0, digits - 1 - std::floor(std::log10(mean)));
    const double rounded = std::round(mean * scale) / scale;
    if (std::abs(rounded - mean) <= tolerance * mean) {
      return RoundCsvTime(rounded);
    }
  }
  return mean;
}

}  // namespace mle
