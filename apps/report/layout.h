// Where everything in a figure goes. Positions are in points (1/72 inch) from
// the lower left corner, so that no label is cut off or written over another.

#ifndef APPS_REPORT_LAYOUT_H_
#define APPS_REPORT_LAYOUT_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/report/axis.h"
#include "apps/report/figure.h"

namespace mle::report {

enum class TextAlign { kLeft, kCenter, kRight };

// A line of text; (x, y) is its anchor, half way up.
struct PlacedText {
  std::string text = {};
  double x = 0.0;
  double y = 0.0;
  TextAlign align = TextAlign::kLeft;
  double size_pt = 8.0;
  bool upright = false;  // turned left by 90°, as the label of a y axis
};

// The frame the data are drawn in.
struct Frame {
  double left = 0.0;
  double right = 0.0;
  double bottom = 0.0;
  double top = 0.0;
};

struct PanelLayout {
  Frame frame = {};
  double y_label_x = 0.0;  // common to a column
  Range x_range = {};
  Range y_range = {};
  std::vector<Tick> x_ticks = {};
  std::vector<Tick> y_ticks = {};
};

// The sample of a line or marker in the legend, from x_begin to x_end.
struct LegendSample {
  Style style = {};
  bool band = false;
  double x_begin = 0.0;
  double x_end = 0.0;
  double y = 0.0;
};

struct Layout {
  double width_pt = 0.0;
  double height_pt = 0.0;
  std::vector<PanelLayout> panels = {};  // as Figure::panels
  std::vector<LegendSample> legend = {};
  std::vector<PlacedText> texts = {};
};

// InvalidArgument if the figure does not validate, or is too small for what it
// is to show.
absl::StatusOr<Layout> MakeLayout(const Figure& figure);

}  // namespace mle::report

#endif  // APPS_REPORT_LAYOUT_H_
