#include "mle/data/usual_step.h"

#include <cmath>

#include "mle/data/csv_numbers.h"
#include "mle/data/robust_statistics.h"

namespace mle {

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
