// A figure's contents as JSON, for the charts of a page (charts.js draws them
// with dygraphs): the same panels, series, lines and markers as the static
// picture, in the same colours.
//
// Series that are long are thinned as in the picture, so that the smallest and
// largest value of each stretch stay. Numbers have 7 digits.

#ifndef APPS_REPORT_CHART_DATA_H_
#define APPS_REPORT_CHART_DATA_H_

#include <string>
#include <string_view>

#include "apps/report/figure.h"

namespace mle::report {

// Safe inside <script type="application/json">. `figure` is valid.
std::string ChartData(const Figure& figure);

// The style sheet and the scripts that a page with charts needs, ready to stand
// inside <style> and <script>: dygraphs (MIT licence) and our own.
std::string_view ChartStyle();
std::string_view ChartLibrary();
std::string_view ChartScript();

}  // namespace mle::report

#endif  // APPS_REPORT_CHART_DATA_H_
