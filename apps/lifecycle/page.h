// The report of mle_lifecycle.

#ifndef APPS_LIFECYCLE_PAGE_H_
#define APPS_LIFECYCLE_PAGE_H_

#include <string>
#include <vector>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/drawing.h"
#include "apps/report/html.h"

namespace mle::lifecycle {

std::string FormatPage(const Campaign& campaign,
                       const std::vector<RateSummary>& summaries,
                       const Valuation& valuation,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_PAGE_H_
