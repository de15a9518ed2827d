// report.html of mle_reproduce: one page that opens without a network.

#ifndef APPS_REPRODUCE_PAGE_H_
#define APPS_REPRODUCE_PAGE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/report/html.h"
#include "apps/reproduce/figures.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {

// `svgs` belong to `figures`, one each, or say why one could not be drawn.
std::string FormatPage(const std::vector<CaseResult>& cases,
                       const std::vector<NamedFigure>& figures,
                       const std::vector<absl::StatusOr<std::string>>& svgs,
                       const report::RunAgain& run_again);

// "E falls from … to …", for each case.
std::vector<std::string> Findings(const std::vector<CaseResult>& cases);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_PAGE_H_
