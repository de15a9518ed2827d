// Test for drift and steps in a part that should be at rest. Internal to
// mle/data.
//
// Under the null hypothesis the samples are white noise about a constant. A
// trend is tested by its slope, a step by the largest difference of the means
// on both sides of a split; the one with the smaller residual is reported.

#ifndef MLE_DATA_QUIET_PART_H_
#define MLE_DATA_QUIET_PART_H_

#include "mle/data/robust_statistics.h"
#include "mle/data/set_point_windows.h"

namespace mle {

// Thresholds above which a part is not quiet.
struct QuietLimits {
  double deviations = 5.0;  // standard errors
  double size = 1.0;        // standard deviations of the noise
};

QuietPart TestQuietPart(const SampleRow& samples, double start_time,
                        double sample_time, QuietLimits limits);

}  // namespace mle

#endif  // MLE_DATA_QUIET_PART_H_
