// Test for drift and steps in a part in which operation should be steady.
//
// Under the null hypothesis the samples are white noise about a constant. A
// trend is tested by its slope, a step by the largest difference of the means
// on both sides of a split; the one with the smaller residual is reported.
//
// Internal to mle/data.

#ifndef MLE_DATA_STEADY_OPERATION_H_
#define MLE_DATA_STEADY_OPERATION_H_

#include "mle/data/robust_statistics.h"
#include "mle/data/set_point_windows.h"

namespace mle {

// Thresholds above which operation is not steady.
struct SteadyLimits {
  double deviations = 5.0;  // standard errors
  double size = 1.0;        // standard deviations of the noise
};

SteadyOperation TestSteadyOperation(const SampleRow& samples, double start_time,
                                    double sample_time, SteadyLimits limits);

}  // namespace mle

#endif  // MLE_DATA_STEADY_OPERATION_H_
