// Sampling and measurement noise of simulated records.

#ifndef MLE_DATA_SAMPLING_H_
#define MLE_DATA_SAMPLING_H_

#include "absl/status/status.h"

namespace mle {

// A Δt (ValidateSampleTime), duration > 0 and finite, at most 10⁹ samples.
absl::Status ValidateSampling(double sample_time, double duration);

// Finite and ≥ 0.
absl::Status ValidateNoiseVariance(double noise_variance);

// Samples at 0, Δt, … up to `duration`, which counts as reached where it is
// missed by less than 1e-6 Δt. For what ValidateSampling() accepts.
int SampleCount(double sample_time, double duration);

}  // namespace mle

#endif  // MLE_DATA_SAMPLING_H_
