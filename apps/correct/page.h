// report.html.

#ifndef APPS_CORRECT_PAGE_H_
#define APPS_CORRECT_PAGE_H_

#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "apps/correct/figures.h"
#include "apps/correct/result.h"
#include "apps/report/html.h"

namespace mle::correct {

// Draws a figure as SVG; a failure is shown in its place.
using DrawFigure =
    std::function<absl::StatusOr<std::string>(const NamedFigure& figure)>;

// Without `draw` the page has no figures.
std::string FormatPage(const Result& result, const DrawFigure& draw,
                       const report::RunAgain& run_again);

}  // namespace mle::correct

#endif  // APPS_CORRECT_PAGE_H_
