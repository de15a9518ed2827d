// Means, intervals and quantiles of many values.
//
// Means have bootstrap intervals (Efron and Tibshirani, An Introduction to the
// Bootstrap, 1993, ch. 13: percentiles of means of resampled runs), since E and
// its ratios are far from Gaussian; quantiles are exact, by linear
// interpolation between order statistics.

#ifndef APPS_EXPERIMENT_DISTRIBUTION_H_
#define APPS_EXPERIMENT_DISTRIBUTION_H_

#include <array>
#include <cstdint>
#include <vector>

namespace mle::experiment {

// Statistics of n ≥ 0 values; NaN where there are none. Values may be infinite.
struct Distribution {
  static constexpr std::array<double, 5> kLevels = {0.05, 0.25, 0.5, 0.75,
                                                    0.95};
  int count = 0;
  double mean = 0.0;
  double mean_low = 0.0;  // ends of the 95 % interval of the mean
  double mean_high = 0.0;
  double deviation = 0.0;  // standard (n − 1); 0 for one value
  double min = 0.0;
  double max = 0.0;
  std::array<double, 5> quantiles = {};  // at kLevels

  double median() const { return quantiles[2]; }
};

// `number` seeds the resampling: a cell's number.
Distribution Describe(std::vector<double> values, std::uint64_t number);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_DISTRIBUTION_H_
