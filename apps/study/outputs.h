// What mle_study leaves beside runs.csv: summary.csv, summary.json, the figures
// and report.html; and the table it prints.

#ifndef APPS_STUDY_OUTPUTS_H_
#define APPS_STUDY_OUTPUTS_H_

#include <string>

#include "absl/status/status.h"
#include "apps/report/html.h"
#include "apps/report/table.h"
#include "apps/study/campaign.h"
#include "apps/study/summary.h"

namespace mle::study {

// E, λ and failures, a row for each of the first `most` cells.
report::Table ErrorTable(const experiment::Campaign& campaign,
                         const StudySummary& summary, int most);

absl::Status WriteOutputs(const std::string& folder, bool figures,
                          const experiment::Campaign& campaign,
                          const StudySummary& summary,
                          const report::RunAgain& run_again);

void PrintSummary(const experiment::Campaign& campaign,
                  const StudySummary& summary);

}  // namespace mle::study

#endif  // APPS_STUDY_OUTPUTS_H_
