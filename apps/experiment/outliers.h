// Outliers in the records of a run, and what is done about them.

#ifndef APPS_EXPERIMENT_OUTLIERS_H_
#define APPS_EXPERIMENT_OUTLIERS_H_

#include <cstdint>
#include <vector>

#include "apps/experiment/options.h"
#include "mle/data/record.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle::experiment {

// Adds 10 to 50 standard deviations of the noise to a share of the samples of
// every output, singly or in bursts to the same side. In the records alone: the
// loop and its noise are those of the run without outliers.
void AddOutliers(const WindowSpec& spec, double noise_variance,
                 std::uint64_t seed, std::vector<Record>& windows);

// The loss of the output-error correction.
OutputErrorOptions OutputErrorOptionsFor(OutlierTreatment treatment);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_OUTLIERS_H_
