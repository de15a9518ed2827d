// report.html of mle_reproduce: one page that opens without a network.

#ifndef APPS_REPRODUCE_PAGE_H_
#define APPS_REPRODUCE_PAGE_H_

#include <string>
#include <vector>

#include "apps/report/drawing.h"
#include "apps/report/html.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {

// With the figures of MakeFigures, drawn, or without any.
std::string FormatPage(const std::vector<CaseResult>& cases,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again);

// "E falls from … to …", for each case.
std::vector<std::string> Findings(const std::vector<CaseResult>& cases);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_PAGE_H_
