// The files beside the report: result.json and lifecycle.csv
// (docs/lifecycle.md).

#ifndef APPS_LIFECYCLE_OUTPUTS_H_
#define APPS_LIFECYCLE_OUTPUTS_H_

#include <string>
#include <utility>
#include <vector>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/summary.h"

namespace mle::lifecycle {

// `flags`: names and values, as they were given.
std::string FormatResult(
    const Campaign& campaign, const std::vector<RateSummary>& summaries,
    const Valuation& valuation, const std::string& command,
    const std::vector<std::pair<std::string, std::string>>& flags);

// A line for each set-point change of each life.
std::string FormatRows(const Campaign& campaign, const Lives& lives,
                       const Valuation& valuation);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_OUTPUTS_H_
