// Whether an output is quiet where it ought to be. Internal to mle/data.
//
// Under the null hypothesis the samples are white noise about a constant. A
// trend is tested by its slope, a step by the largest difference of the means
// on both sides of a split; of the two the one that leaves less is reported.

#ifndef MLE_DATA_QUIET_PART_H_
#define MLE_DATA_QUIET_PART_H_

#include "mle/data/robust_statistics.h"
#include "mle/data/set_point_windows.h"

namespace mle {

// `threshold`: standard deviations from which on it is not quiet.
QuietPart TestQuietPart(const SampleRow& samples, double start_time,
                        double sample_time, double threshold);

}  // namespace mle

#endif  // MLE_DATA_QUIET_PART_H_
