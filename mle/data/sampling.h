// The sampling of simulated records, and of the rows of files.

#ifndef MLE_DATA_SAMPLING_H_
#define MLE_DATA_SAMPLING_H_

#include <vector>

#include "absl/status/status.h"
#include "mle/data/record.h"

namespace mle {

// A Δt (ValidateSampleTime), duration > 0 and finite, at most 10⁹ samples.
absl::Status ValidateSampling(double sample_time, double duration);

// Finite and ≥ 0.
absl::Status ValidateNoiseVariance(double noise_variance);

// Samples at 0, Δt, … up to `duration`, which counts as reached where it is
// missed by less than 1e-6 Δt. For what ValidateSampling() accepts.
int SampleCount(double sample_time, double duration);

// The usual distance of the samples of an output that are measured, in samples:
// 1, or more of a laboratory's; 0 where none follows another.
int MeasuredEvery(const std::vector<Record>& records, int output);

// The usual distance between the rows of a file, of steps above 0, at least
// one: the mean of those near the median, rounded to as few digits as keep it
// to 1e-6, or, where steps are uneven, to 0.5 %.
double UsualStep(const std::vector<double>& steps);

}  // namespace mle

#endif  // MLE_DATA_SAMPLING_H_
