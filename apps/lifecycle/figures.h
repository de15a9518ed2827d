// The figures of mle_lifecycle.

#ifndef APPS_LIFECYCLE_FIGURES_H_
#define APPS_LIFECYCLE_FIGURES_H_

#include <vector>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/drawing.h"

namespace mle::lifecycle {

// Cost against the time between updates, the map of savings by policy and rate
// of ageing (saving_map.h), cost against the rate, and, for the first seed at
// the rate nearest to 1, cost and model error over time. Those that would show
// nothing are left out: a single interval, a single rate.
std::vector<report::NamedFigure> MakeFigures(
    const Campaign& campaign, const Lives& lives,
    const std::vector<RateSummary>& summaries, const Valuation& valuation);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_FIGURES_H_
