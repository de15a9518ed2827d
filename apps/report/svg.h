// A figure as SVG: the one way figures are drawn. PNG and PDF are converted
// from the file made here (drawing.h).
//
// The same figure gives the same bytes. The picture needs nothing else: its
// colours are attributes, those of dark mode a style sheet; it has no ids, so
// that any number of pictures can stand on one page, and nothing active. Text
// is cleaned and escaped. Lengths are in points (1/72 inch).
//
// Programs may read back the following: each panel is a
// <g class="panel" data-x="MIN MAX" data-y="MIN MAX">, with " log" after the
// range of a logarithmic axis. In it, <svg class="plot"> is the frame; a
// series is a <g class="series"> with its label as <title>, whose paths have
// their points, from the upper left corner of the frame, behind the capital
// letters M, L, H and V.

#ifndef APPS_REPORT_SVG_H_
#define APPS_REPORT_SVG_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/report/figure.h"

namespace mle::report {

// A whole file. `title` names the picture, `description` says in words what is
// to be seen. InvalidArgument as MakeLayout.
absl::StatusOr<std::string> SvgFile(const Figure& figure,
                                    std::string_view title,
                                    std::string_view description);

// An element of an HTML page whose style sheet has FigureStyle(): as wide as
// there is room, within the limits of legible text.
absl::StatusOr<std::string> SvgElement(const Figure& figure,
                                       std::string_view description);

// The style sheet of figures: their colours in dark mode.
std::string FigureStyle();

}  // namespace mle::report

#endif  // APPS_REPORT_SVG_H_
