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

// The elements that pictures of figures are made of (svg.h). Coordinates have
// two decimals and lie within ±100,000.

// The colour of what has no role, in light and in dark mode, and the name of
// its class.
struct SvgColour {
  const char* name;
  const char* light;
  const char* dark;
};
inline constexpr SvgColour kInk = {"ink", "#222222", "#e4e8ec"};
inline constexpr SvgColour kAxis = {"axis", "#555555", "#8a939c"};
inline constexpr SvgColour kGrid = {"grid", "#e2e2e2", "#323a43"};
inline constexpr SvgColour kGround = {"ground", "#ffffff", "#1a1f24"};
inline constexpr SvgColour kCell = {"cell", "#56b4e9", "#1f6a9c"};

// 12.346 is "12.35", 12.0 is "12", −0.001 is "0".
std::string Coordinate(double value);

// ` name="12.35"`.
std::string Attribute(std::string_view name, double value);

// The class and, as an attribute, the colour it has in light mode. What is
// drawn has that colour as "currentColor".
std::string Paint(const SvgColour& colour);
std::string Paint(Role role, std::string_view more_classes);

class SvgPath {
 public:
  void MoveTo(double x, double y);
  void LineTo(double x, double y);
  // A line by itself.
  void AddLine(double from_x, double from_y, double to_x, double to_y) {
    MoveTo(from_x, from_y);
    LineTo(to_x, to_y);
  }
  void Close() { d_ += 'Z'; }
  // A shape of diameter `size` about (x, y), which alone stands behind a
  // capital letter; the rest of the shape is relative to it.
  void AddShape(MarkerShape shape, double x, double y, double size);

  bool empty() const { return d_.empty(); }
  const std::string& d() const { return d_; }

 private:
  std::string d_;
  std::string x_;  // where the path has got to
  std::string y_;
};

// The elements. A path that is empty gives none. `more` are attributes, each
// with a space before it.
std::string Stroked(const SvgPath& path, double width_pt,
                    std::string_view more = "");
std::string Line(const SvgPath& path, const Style& style);
std::string Shapes(const SvgPath& path, const Style& style);
std::string Rectangle(double x, double y, double width, double height,
                      std::string_view more);
// A <title>, shown where the pointer rests; empty if `label` is empty.
std::string Title(std::string_view label);

}  // namespace mle::report

#endif  // APPS_REPORT_SVG_H_
