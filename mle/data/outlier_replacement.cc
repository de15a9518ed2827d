#include "mle/data/outlier_replacement.h"

#include "mle/data/gap_bridging.h"

namespace mle {

int ReplaceOutliers(const ProcessModel& model,
                    const OutlierReplacementOptions& options,
                    std::vector<Record>& records) {
  HealthOptions health;
  health.outliers = options.outliers;
  const HealthReport report = CheckHealth(records, model, health);
  MarkOptions mark;
  mark.frozen = false;
  const int found = MarkBad(report, mark, records);
  if (options.max_gap > 0) {
    for (Record& record : records) {
      BridgeGaps(options.max_gap, /*bridge_outputs=*/true, record);
    }
  }
  return found;
}

}  // namespace mle
