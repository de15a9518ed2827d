// Figures as a page or an SVG file shows them, read back from the picture: each
// place is exact to a hundredth of a point, within 10⁻⁴ of its axis.

#ifndef TESTS_APPS_REPORT_SHOWN_FIGURES_H_
#define TESTS_APPS_REPORT_SHOWN_FIGURES_H_

#include <string>
#include <string_view>
#include <vector>

#include "apps/report/figure.h"

namespace mle::report {

struct ShownSeries {
  std::string label;
  // In the units of the axes. Lines that break go on with the next point.
  std::vector<double> x;
  std::vector<double> y;
};

struct ShownPanel {
  Range x;
  Range y;
  std::vector<ShownSeries> series = {};  // markers among them
  int spans = 0;
};

struct ShownFigure {
  std::vector<ShownPanel> panels;
  std::vector<std::string> texts;
};

// A failure of the test if `markup` is not well formed. Pictures of a page that
// repeat a figure for a narrow screen are left out.
std::vector<ShownFigure> FiguresOf(std::string_view markup, bool html);

}  // namespace mle::report

#endif  // TESTS_APPS_REPORT_SHOWN_FIGURES_H_
