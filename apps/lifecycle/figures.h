// What mle_lifecycle shows in pictures.

#ifndef APPS_LIFECYCLE_FIGURES_H_
#define APPS_LIFECYCLE_FIGURES_H_

#include <string>
#include <vector>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/figure.h"

namespace mle::lifecycle {

// A figure, the name of its files, and what it shows, in words.
struct NamedFigure {
  std::string name;
  std::string caption;
  report::Figure figure;
};

// Cost against the time between updates, cost against the rate of ageing, and,
// for the first seed at the rate nearest to 1, cost and model error over time.
// Those that would show nothing are left out: a single interval, a single rate.
std::vector<NamedFigure> MakeFigures(const Campaign& campaign,
                                     const Lives& lives,
                                     const std::vector<RateSummary>& summaries,
                                     const Valuation& valuation);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_FIGURES_H_
