#include "mle/data/outlier_replacement.h"

#include "mle/data/gap_bridging.h"

namespace mle {

int ReplaceOutliers(const ProcessModel& model,
                    const OutlierReplacementOptions& options,
                    std::vector<Record>& records) {
  MarkOptions mark;
  mark.frozen = false;
  int found = 0;
  // Among few neighbours a burst would be taken for the signal.
  const int wide = options.longest_burst + 2;
  for (const int half_width : {wide, options.outliers.half_width}) {
    if (half_width == wide && wide <= options.outliers.half_width) continue;
    HealthOptions health;
    health.outliers = options.outliers;
    health.outliers.half_width = half_width;
    found += MarkBad(CheckHealth(records, model, health), mark, records);
  }
  if (options.max_gap > 0) {
    for (Record& record : records) {
      BridgeGaps(options.max_gap, /*bridge_outputs=*/true, record);
    }
  }
  return found;
}

}  // namespace mle
