// A figure as a gnuplot program.
//
// Of a label, only letters, blanks and characters beyond ASCII stand in the
// program as they are, the rest as octal escapes, so that nothing in it can be
// read as anything but text; and it is drawn "noenhanced", without markup.
// Data are inline, in the shortest decimals that give back the same double.

#ifndef APPS_REPORT_GNUPLOT_SCRIPT_H_
#define APPS_REPORT_GNUPLOT_SCRIPT_H_

#include <string>
#include <string_view>

#include "apps/report/figure.h"
#include "apps/report/layout.h"

namespace mle::report {

// How a terminal of gnuplot counts. Each of them has its own units.
struct Terminal {
  std::string name_and_size = {};  // e.g. "svg size 642,302 fixed"
  double font_per_pt = 1.0;        // font size to ask for, for one point
  double line_per_pt = 1.0;        // line width likewise
  double marker_per_pt = 1.0;  // diameter of a marker likewise, in pointsize
  // A dash of length 1 on a line of width w is drawn dash_length · w long, and
  // no shorter than on a line of width dash_min_width_pt.
  double dash_length = 1.0;
  double dash_min_width_pt = 0.0;
};

// CleanText(text) as a string of gnuplot: QuoteForGnuplot("a'") = "a\\047" with
// the double quotes.
std::string QuoteForGnuplot(std::string_view text);

std::string GnuplotScript(const Figure& figure, const Layout& layout,
                          const Terminal& terminal);

}  // namespace mle::report

#endif  // APPS_REPORT_GNUPLOT_SCRIPT_H_
