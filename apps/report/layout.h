// Where everything in a figure goes. Positions are in points (1/72 inch) from
// the lower left corner, so that no label is cut off or written over another.

#ifndef APPS_REPORT_LAYOUT_H_
#define APPS_REPORT_LAYOUT_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/report/figure.h"

namespace mle::report {

// The range of an axis and its ticks, and where a value lies on it.

struct Tick {
  double value = 0.0;
  std::string label = {};  // empty: a minor tick
};

// True if a value can be shown on such an axis: finite, of a size that can
// still be scaled, and positive if logarithmic.
bool IsShown(double value, bool log);

// The ranges of a panel's axes: as asked for, else what its series, lines,
// spans and markers need. Along x just that; along y with a twentieth to spare
// at each end. 0 … 1 (0.1 … 10 if logarithmic) if there is nothing to show.
Range XRange(const Panel& panel);
Range YRange(const Panel& panel);

// About `wanted` (≥ 2) labelled ticks within `range`. Linear: at multiples of
// 1, 2 or 5 times a power of ten. Logarithmic: at powers of ten, or between
// them where the range is short; minor ticks at 2 … 9 times a power of ten.
std::vector<Tick> Ticks(const Range& range, bool log, int wanted);

// At 0, 1, 2, …, one for each name.
std::vector<Tick> NamedTicks(const std::vector<std::string>& names);

// 0 at range.min, 1 at range.max.
double Fraction(double value, const Range& range, bool log);

// At most `wanted` (≥ 2) and one of them within `range`, all labelled; where
// the range has no two whole seconds, as on an axis without dates.
std::vector<Tick> DateTicks(const Range& range, const DateScale& dates,
                            int wanted);

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
