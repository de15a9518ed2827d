// Test for drift and steps in a part that should be at rest.
//
// Under the null hypothesis the samples are white noise about a constant. A
// trend is tested by its slope, a step by the largest difference of the means
// on both sides of a split; the one with the smaller residual is reported.

#ifndef MLE_DATA_QUIET_PART_H_
#define MLE_DATA_QUIET_PART_H_

#include "mle/data/robust_statistics.h"

namespace mle {

// A quiet part of an output, less the model's response to the inputs, with
// which control compensates disturbances of the output.
struct QuietPart {
  enum class Verdict {
    kUnknown,    // too short to say
    kQuiet,      // noise about a constant
    kDrifting,   // a trend
    kDisturbed,  // a step
  };
  Verdict verdict = Verdict::kUnknown;
  double noise = 0.0;       // standard deviation of its white part
  double size = 0.0;        // of the trend over the part, or of the step
  double deviations = 0.0;  // `size` over its standard error in white noise
  double time = 0.0;        // of the step
};

// Thresholds above which a part is not quiet.
struct QuietLimits {
  double deviations = 5.0;  // standard errors
  double size = 1.0;        // standard deviations of the noise
};

QuietPart TestQuietPart(const SampleRow& samples, double start_time,
                        double sample_time, QuietLimits limits);

}  // namespace mle

#endif  // MLE_DATA_QUIET_PART_H_
