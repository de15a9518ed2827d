// What mle_study leaves beside runs.csv: summary.csv, summary.json, the figures
// and report.html; and what it prints.

#ifndef APPS_STUDY_OUTPUTS_H_
#define APPS_STUDY_OUTPUTS_H_

#include <string>

#include "absl/status/status.h"
#include "apps/report/html.h"
#include "apps/study/campaign.h"
#include "apps/study/summary.h"

namespace mle::study {

absl::Status WriteOutputs(const std::string& folder, bool figures,
                          const experiment::Campaign& campaign,
                          const StudySummary& summary,
                          const report::RunAgain& run_again);

void PrintSummary(const experiment::Campaign& campaign,
                  const StudySummary& summary);

}  // namespace mle::study

#endif  // APPS_STUDY_OUTPUTS_H_
