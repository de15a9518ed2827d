// Single samples far from their neighbours, by the Hampel filter: a sample is
// an outlier if it is more than `threshold` robust deviations from the median
// of the samples around it. The deviation is the larger one of those samples'
// own and of the channel's white noise. A median follows every monotone signal,
// so that the response to a set point, however steep, has none.
//
// Source: Pearson, Outliers in process modeling and identification, IEEE
// Transactions on Control Systems Technology 10 (2002).

#ifndef MLE_DATA_OUTLIERS_H_
#define MLE_DATA_OUTLIERS_H_

#include <vector>

#include "mle/data/channel_health.h"
#include "mle/data/robust_statistics.h"

namespace mle {

// Their positions, ascending. Needs at least half_width good samples around.
std::vector<int> FindOutliers(const SampleRow& samples,
                              const OutlierOptions& options = {});

}  // namespace mle

#endif  // MLE_DATA_OUTLIERS_H_
