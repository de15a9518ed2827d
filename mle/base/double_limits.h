// Values of double that computations name often.

#ifndef MLE_BASE_DOUBLE_LIMITS_H_
#define MLE_BASE_DOUBLE_LIMITS_H_

#include <limits>

namespace mle {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
// From 1 to the next larger number: 2⁻⁵².
inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// Samples are squared, summed and compared as variances: beyond this limit the
// results would leave the range of double precision.
inline constexpr double kLargestSample = 1e60;

}  // namespace mle

#endif  // MLE_BASE_DOUBLE_LIMITS_H_
