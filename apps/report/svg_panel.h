// One panel of a figure as SVG, without its texts.

#ifndef APPS_REPORT_SVG_PANEL_H_
#define APPS_REPORT_SVG_PANEL_H_

#include <string>

#include "apps/report/figure.h"
#include "apps/report/layout.h"

namespace mle::report {

// <g class="panel">, as svg.h says.
std::string SvgPanel(const Panel& panel, const PanelLayout& placed,
                     double figure_height_pt);

}  // namespace mle::report

#endif  // APPS_REPORT_SVG_PANEL_H_
