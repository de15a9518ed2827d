// The content of a figure, free of how it is drawn (svg.h draws it).
//
// A figure is a grid of panels under one shared legend. Series, reference lines
// and markers have a role, which stands for the same thing in every figure and
// carries its look; colours are those of Okabe and Ito (2008), which the colour
// blind can tell apart, and roles shown together differ in line or shape too.
//
//   Figure figure{.height_cm = 6.0, .columns = 2};
//   Panel& panel = figure.AddPanel("gain");
//   panel.x = {.label = "λ", .log = true};
//   panel.y = {.label = "E", .log = true};
//   panel.series.push_back(MakeSeries(Role::kCorrected, "corrected", lambda,
//   e)); panel.lines.push_back(HorizontalLine(Role::kInitial, "initial",
//   19363.0)); panel.markers.push_back(MakeMarker(Role::kChosen, "chosen λ",
//   3e-5, 8.1));
//
// Labels are taken literally, in UTF-8; there is no markup, so subscripts and
// Greek are Unicode characters (λ, φ₁₁).

#ifndef APPS_REPORT_FIGURE_H_
#define APPS_REPORT_FIGURE_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace mle::report {

// The kind of thing that is drawn; see StyleOf for its look.
enum class Role {
  kInitial,        // the model before correction
  kTrue,           // the plant
  kCorrected,      // the corrected model
  kUnregularised,  // the correction with λ = 0
  kFitted,         // a first-order-plus-dead-time fit
  kAlternative,    // another method, for comparison
  kMeasured,       // a recorded signal
  kSetPoint,       // its set point
  kReference,      // a limit or a bound
  kChosen,         // the λ the method chose
  kBest,           // the λ best in hindsight
  kUnused,         // a sample that is bad, or not to be used
  kWindow,         // what is used of a record
};

enum class LineStyle { kNone, kSolid, kDashed, kDotted, kDashDotted };
enum class MarkerShape { kNone, kCross, kPlus, kCircle, kDisc };

struct Style {
  Role colour = Role::kCorrected;  // whose colour is used
  LineStyle line = LineStyle::kSolid;
  double width_pt = 1.0;
  MarkerShape marker = MarkerShape::kNone;
  double marker_size_pt = 5.0;
};

// The look a role has by default.
Style StyleOf(Role role);

// Its colour on white, and on the dark ground of a page, as "#rrggbb"; its
// name, of letters and "-". Colours are those of Okabe and Ito (Color Universal
// Design, 2008), which the colour-blind can tell apart, or lighter.
std::string ColourOf(Role role);
std::string DarkColourOf(Role role);
std::string NameOf(Role role);
// All of them, in the order above.
const std::vector<Role>& AllRoles();

// Points (x_i, y_i) joined by a line. A point that is not finite, or not
// positive on a logarithmic axis, breaks the line.
struct Series {
  std::string label =
      {};  // in the legend; empty: none. Equal labels appear once.
  std::vector<double> x = {};
  std::vector<double> y = {};
  // A band around the line, from lower to upper; both empty: none.
  std::vector<double> lower = {};
  std::vector<double> upper = {};
  Style style = {};
  // Each value is held until the next one (a staircase).
  bool steps = false;
  // 0 draws every point; else at most about this many (≥ 6), such that the
  // smallest and largest value of each stretch stay.
  int max_points = 0;
};

enum class Orientation { kHorizontal, kVertical };

// A line across the whole panel, at y = value or x = value, behind the series.
// One that is not finite is not drawn, and has no place in the legend.
struct ReferenceLine {
  std::string label = {};
  Orientation orientation = Orientation::kHorizontal;
  double value = 0.0;
  Style style = {};
};

// A stretch of x, shaded over the whole height of the panel, behind the lines.
struct Span {
  std::string label = {};
  double from = 0.0;  // < to, both finite
  double to = 0.0;
  Style style = {};
};

// A square of a map, from x − ½ to x + ½ and y − ½ to y + ½, with words in it.
struct Cell {
  double x = 0.0;
  double y = 0.0;
  double shade = 0.0;  // of its ground: from 0, white, to 1
  std::vector<std::string> lines = {};
};

// A single point, on top of all; not drawn if not finite.
struct Marker {
  std::string label = {};
  double x = 0.0;
  double y = 0.0;
  Style style = {};
};

struct Range {
  double min = 0.0;
  double max = 1.0;
};

// Values of an axis that stand for dates: seconds since 1970-01-01T00:00:00Z
// are origin + value × seconds_per_unit.
struct DateScale {
  double origin = 0.0;
  double seconds_per_unit = 1.0;  // > 0
  absl::TimeZone zone = absl::UTCTimeZone();
};

struct Axis {
  std::string label = {};
  bool log = false;
  std::optional<Range> range = {};  // default: what the panel shows, rounded
  // Names of the places 0, 1, 2, … instead of numbers; the range is theirs.
  std::vector<std::string> names = {};
  // Ticks at dates instead of numbers; of a linear axis without names.
  std::optional<DateScale> dates = {};
};

struct Panel {
  std::string title = {};
  Axis x = {};
  Axis y = {};
  // Drawn in this order, the later ones on top; then the markers.
  std::vector<Series> series = {};
  std::vector<ReferenceLine> lines = {};
  std::vector<Marker> markers = {};
  std::vector<Span> spans = {};
  std::vector<Cell> cells = {};
};

struct Figure {
  std::string title = {};
  // 8.5 cm is one column of a two-column paper, 17 cm its full width.
  double width_cm = 17.0;     // [3, 100]
  double height_cm = 8.0;     // [3, 100]
  double font_size_pt = 8.0;  // [4, 40]
  int columns = 1;
  bool legend = true;              // one for all panels, above them
  std::vector<Panel> panels = {};  // row by row; the last row may be short

  // Appends an empty panel. The reference is good until the next call.
  Panel& AddPanel(std::string title);

  // InvalidArgument names the panel, the series and what is wrong with it.
  absl::Status Validate() const;
};

// With the style of the role.
Series MakeSeries(Role role, std::string label, std::vector<double> x,
                  std::vector<double> y);
ReferenceLine HorizontalLine(Role role, std::string label, double y);
ReferenceLine VerticalLine(Role role, std::string label, double x);
Marker MakeMarker(Role role, std::string label, double x, double y);
Span MakeSpan(Role role, std::string label, double from, double to);

// `series` with at most about max_points points (see there) if x increases; as
// it is if max_points is 0. Stretches are equally long on the axis as drawn.
Series Downsample(const Series& series, bool log_x);

}  // namespace mle::report

#endif  // APPS_REPORT_FIGURE_H_
