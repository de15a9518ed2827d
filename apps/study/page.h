// The report of mle_study.

#ifndef APPS_STUDY_PAGE_H_
#define APPS_STUDY_PAGE_H_

#include <string>
#include <vector>

#include "apps/report/drawing.h"
#include "apps/report/html.h"
#include "apps/study/campaign.h"
#include "apps/study/summary.h"

namespace mle::study {

std::string FormatPage(const experiment::Campaign& campaign,
                       const StudySummary& summary,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again);

}  // namespace mle::study

#endif  // APPS_STUDY_PAGE_H_
