// Location and spread of samples some of which may be bad. NaN is ignored
// throughout.

#ifndef MLE_DATA_ROBUST_STATISTICS_H_
#define MLE_DATA_ROBUST_STATISTICS_H_

#include <vector>

#include "Eigen/Core"

namespace mle {

using SampleRow = Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>>;

// Standard deviation of Gaussian samples / median |x|.
inline constexpr double kGaussianDeviation = 1.4826;

// The median; NaN without samples. Reorders `values`, which hold no NaN.
double MedianInPlace(std::vector<double>& values);

// 1.4826 times the median distance from the median: the standard deviation of
// Gaussian samples. 0 of fewer than two.
double RobustDeviation(const SampleRow& samples);

// Standard deviation of the white noise in a signal that is slow beside it,
// from the differences of neighbouring samples: 1.4826 median |Δy| / √2, or
// their root mean square where rounding makes that 0.
double WhiteDeviation(const SampleRow& samples);

// Mean of the samples within six robust deviations of their median; `used` is
// their number. NaN without samples.
double TrimmedMean(const SampleRow& samples, int& used);

// The largest step of which most differences between neighbours are whole
// multiples; 0 if no such step exists, or if it is negligible: below a fiftieth
// of `noise` (or of the usual difference, if `noise` is 0).
double FindQuantum(const std::vector<SampleRow>& rows, double noise);

}  // namespace mle

#endif  // MLE_DATA_ROBUST_STATISTICS_H_
