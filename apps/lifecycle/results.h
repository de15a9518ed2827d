// What a life cycle leaves in its folder: result.json, lifecycle.csv, the
// figures and report.html.

#ifndef APPS_LIFECYCLE_RESULTS_H_
#define APPS_LIFECYCLE_RESULTS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/run_again.h"
#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/request.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/html.h"

namespace mle::lifecycle {

struct Results {
  Lives lives;
  std::vector<RateSummary> summaries;
  Valuation valuation;
};

// Of lives with what they were asked for.
Results Evaluate(const Request& request, Lives lives);

// How the results were asked for: a command or a call, its options, and how the
// page says it.
struct Asked {
  std::string call;
  NamesAndValues options;
  report::RunAgain run_again;
};

// Into the campaign's folder, all or none.
absl::Status WriteResults(const Request& request, const Results& results,
                          const Asked& asked);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_RESULTS_H_
