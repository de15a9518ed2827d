// The report of mle_lifecycle.

#ifndef APPS_LIFECYCLE_PAGE_H_
#define APPS_LIFECYCLE_PAGE_H_

#include <string>
#include <vector>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/drawing.h"
#include "apps/report/html.h"
#include "apps/report/table.h"

namespace mle::lifecycle {

// The findings, a sentence or two for each rate of ageing.
std::vector<std::string> Findings(const Campaign& campaign,
                                  const std::vector<RateSummary>& summaries);

// A row for each policy.
report::Table PolicyTable(const RateSummary& rate);
report::Table CostTable(const RateSummary& rate);
// Policies by rates: the part of the avoidable cost that is saved, in percent.
report::Table SavingTable(const std::vector<RateSummary>& summaries);

std::string FormatPage(const Campaign& campaign,
                       const std::vector<RateSummary>& summaries,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_PAGE_H_
