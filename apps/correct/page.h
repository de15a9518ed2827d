// report.html.

#ifndef APPS_CORRECT_PAGE_H_
#define APPS_CORRECT_PAGE_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"
#include "apps/report/drawing.h"
#include "apps/report/html.h"

namespace mle::correct {

// With the figures of MakeFigures, drawn, or without any.
std::string FormatPage(const Result& result,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again);

}  // namespace mle::correct

#endif  // APPS_CORRECT_PAGE_H_
