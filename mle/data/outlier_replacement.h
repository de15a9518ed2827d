// Outliers of the outputs replaced, so that records can be used by a regression
// on lags, where one bad sample stands in the rows of the next d samples as
// well: a loss that spares outlying responses does nothing about those, and
// marking the sample as bad loses them all.
//
//   CheckHealth()  finds samples far from their neighbours' median, first among
//                  so many neighbours that a burst is the smaller part of them
//   MarkBad()      makes them NaN: enough for CorrectStructure(), which passes
//                  over bad outputs
//   BridgeGaps()   puts the line between their neighbours in their place: for
//                  CorrectModel()
//
// docs/estimators.md has what it is worth.

#ifndef MLE_DATA_OUTLIER_REPLACEMENT_H_
#define MLE_DATA_OUTLIER_REPLACEMENT_H_

#include <vector>

#include "mle/data/channel_health.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct OutlierReplacementOptions {
  OutlierOptions outliers;
  // Up to so many outliers in a row are found, ≥ 1. A peak of the output itself
  // must last longer.
  int longest_burst = 10;
  // Gaps of outputs of up to this many samples are filled, whether outliers
  // left them or they were there; ≥ 0, 0 only marks the outliers as bad.
  int max_gap = 10;
};

// How many outliers there were. The records are of the model's channels.
int ReplaceOutliers(const ProcessModel& model,
                    const OutlierReplacementOptions& options,
                    std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_DATA_OUTLIER_REPLACEMENT_H_
