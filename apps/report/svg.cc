#include "apps/report/svg.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/report/layout.h"
#include "apps/report/text.h"
#include "mle/base/status.h"

namespace mle::report {
namespace {

// One panel of a figure as SVG, without its texts.

// A sheet of paper has no room for more points.
constexpr int kMostPoints = 4000;

constexpr double kMajorTick = 2.6;
constexpr double kMinorTick = 1.5;

// A point of a series as drawn: stairs have more of them than the series.
struct Place {
  double x = 0.0;  // in the units of the axis
  std::size_t i = 0;
};

// A panel in coordinates from the upper left corner of its frame.
class PanelWriter {
 public:
  PanelWriter(const Panel& panel, const PanelLayout& placed)
      : panel_(panel),
        placed_(placed),
        width_(placed.frame.right - placed.frame.left),
        height_(placed.frame.top - placed.frame.bottom) {}

  std::string Write(double figure_height) const {
    const Frame& frame = placed_.frame;
    const double top = figure_height - frame.top;
    std::string out = absl::StrCat(
        "<g class=\"panel\" data-x=\"", RangeOf(placed_.x_range, panel_.x.log),
        "\" data-y=\"", RangeOf(placed_.y_range, panel_.y.log),
        DatesOf(panel_.x), "\" transform=\"translate(", Coordinate(frame.left),
        " ", Coordinate(top), ")\">\n");
    // A viewport of its own: what is in it ends at the frame.
    absl::StrAppend(&out, "<svg class=\"plot\"", Attribute("width", width_),
                    Attribute("height", height_), ">\n");
    for (const Span& span : panel_.spans) out += SpanOf(span);
    for (const Cell& cell : panel_.cells) out += CellOf(cell);
    if (panel_.cells.empty()) out += Grid();
    for (const ReferenceLine& line : panel_.lines) out += Across(line);
    std::string points;
    for (const Series& series : panel_.series) {
      out += SeriesOf(series, points);
    }
    absl::StrAppend(&out, "</svg>\n", Axes(), points);
    for (const Marker& marker : panel_.markers) out += MarkerOf(marker);
    return out + "</g>\n";
  }

 private:
  // An attribute for the script of the page: origin, unit and zone of the dates
  // on the axis. Empty without dates.
  static std::string DatesOf(const Axis& axis) {
    if (!axis.dates.has_value()) return "";
    const std::string zone = axis.dates->zone.name();
    const bool is_plain = std::all_of(zone.begin(), zone.end(), [](char c) {
      return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '/' ||
             c == '_' || c == '-' || c == '+';
    });
    if (!is_plain) return "";
    return absl::StrFormat("\" data-dates=\"%.17g %.17g %s", axis.dates->origin,
                           axis.dates->seconds_per_unit, zone);
  }
  static std::string RangeOf(const Range& range, bool log) {
    return absl::StrFormat("%.10g %.10g%s", range.min, range.max,
                           log ? " log" : "");
  }

  double X(double value) const {
    return width_ * Fraction(value, placed_.x_range, panel_.x.log);
  }
  double Y(double value) const {
    return height_ * (1.0 - Fraction(value, placed_.y_range, panel_.y.log));
  }
  bool IsInside(double x, double y) const {
    return IsShown(x, panel_.x.log) && IsShown(y, panel_.y.log) &&
           x >= placed_.x_range.min && x <= placed_.x_range.max &&
           y >= placed_.y_range.min && y <= placed_.y_range.max;
  }

  std::string Grid() const {
    SvgPath lines;
    for (const Tick& tick : placed_.x_ticks) {
      if (tick.label.empty()) continue;
      lines.AddLine(X(tick.value), 0.0, X(tick.value), height_);
    }
    for (const Tick& tick : placed_.y_ticks) {
      if (tick.label.empty()) continue;
      lines.AddLine(0.0, Y(tick.value), width_, Y(tick.value));
    }
    return Stroked(lines, 0.5, " " + Paint(kGrid));
  }

  std::string Axes() const {
    SvgPath lines;
    lines.MoveTo(0.0, 0.0);
    lines.LineTo(0.0, height_);
    lines.LineTo(width_, height_);
    const auto length = [](const Tick& tick) {
      return tick.label.empty() ? kMinorTick : kMajorTick;
    };
    for (const Tick& tick : placed_.x_ticks) {
      lines.AddLine(X(tick.value), height_, X(tick.value),
                    height_ + length(tick));
    }
    for (const Tick& tick : placed_.y_ticks) {
      lines.AddLine(0.0, Y(tick.value), -length(tick), Y(tick.value));
    }
    return Stroked(lines, 0.6, " " + Paint(kAxis));
  }

  std::string SpanOf(const Span& span) const {
    // On a logarithmic axis what begins at 0 begins at its end.
    const double from =
        IsShown(span.from, panel_.x.log) ? span.from : placed_.x_range.min;
    if (span.to <= placed_.x_range.min) return "";
    return absl::StrCat(
        "<g ", Paint(span.style.colour, "span "), ">\n", Title(span.label),
        Rectangle(X(from), -1.0, X(span.to) - X(from), height_ + 2.0,
                  " fill-opacity=\"0.2\" stroke=\"currentColor\" "
                  "stroke-width=\"0.4\""),
        "</g>\n");
  }

  std::string CellOf(const Cell& cell) const {
    // Strong enough to be told apart, such that words on it can be read.
    return Rectangle(
        X(cell.x - 0.5), Y(cell.y + 0.5), X(cell.x + 0.5) - X(cell.x - 0.5),
        Y(cell.y - 0.5) - Y(cell.y + 0.5),
        absl::StrCat(" ", Paint(kCell),
                     Attribute("fill-opacity", 0.75 * cell.shade),
                     " stroke=\"currentColor\" stroke-opacity=\"0.4\" "
                     "stroke-width=\"0.5\""));
  }

  std::string Across(const ReferenceLine& line) const {
    const bool horizontal = line.orientation == Orientation::kHorizontal;
    if (!IsShown(line.value, horizontal ? panel_.y.log : panel_.x.log)) {
      return "";
    }
    const Range& range = horizontal ? placed_.y_range : placed_.x_range;
    if (line.value < range.min || line.value > range.max) return "";
    SvgPath path;
    if (horizontal) {
      path.AddLine(0.0, Y(line.value), width_, Y(line.value));
    } else {
      path.AddLine(X(line.value), 0.0, X(line.value), height_);
    }
    return absl::StrCat("<g ", Paint(line.style.colour, "across "), ">\n",
                        Title(line.label), Line(path, line.style), "</g>\n");
  }

  std::string MarkerOf(const Marker& marker) const {
    if (!IsInside(marker.x, marker.y)) return "";
    SvgPath path;
    path.AddShape(marker.style.marker, X(marker.x), Y(marker.y),
                  marker.style.marker_size_pt);
    return absl::StrCat("<g ", Paint(marker.style.colour, "series "), ">\n",
                        Title(marker.label), Shapes(path, marker.style),
                        "</g>\n");
  }

  bool HasPlace(const Series& series, std::size_t i) const {
    return IsShown(series.x[i], panel_.x.log) &&
           IsShown(series.y[i], panel_.y.log) &&
           (series.lower.empty() || (IsShown(series.lower[i], panel_.y.log) &&
                                     IsShown(series.upper[i], panel_.y.log)));
  }

  // The parts of the series between its gaps, stairs with their corners.
  std::vector<std::vector<Place>> PartsOf(const Series& series) const {
    std::vector<std::vector<Place>> parts;
    bool open = false;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!HasPlace(series, i)) {
        open = false;
        continue;
      }
      if (!open) parts.emplace_back();
      open = true;
      parts.back().push_back({series.x[i], i});
      if (series.steps && i + 1 < series.x.size() &&
          IsShown(series.x[i + 1], panel_.x.log)) {
        parts.back().push_back({series.x[i + 1], i});
      }
    }
    return parts;
  }

  std::string Band(const Series& series,
                   const std::vector<std::vector<Place>>& parts) const {
    SvgPath path;
    if (series.lower.empty()) return "";
    for (const std::vector<Place>& part : parts) {
      path.MoveTo(X(part[0].x), Y(series.upper[part[0].i]));
      for (const Place& at : part) path.LineTo(X(at.x), Y(series.upper[at.i]));
      for (auto at = part.rbegin(); at != part.rend(); ++at) {
        path.LineTo(X(at->x), Y(series.lower[at->i]));
      }
      path.Close();
    }
    if (path.empty()) return "";
    return absl::StrCat("<path class=\"band\" d=\"", path.d(),
                        "\" fill=\"currentColor\" fill-opacity=\"0.2\"/>\n");
  }

  // Its line; its points are added to `points`, which lie above all lines and
  // are not cut at the frame.
  std::string SeriesOf(const Series& whole, std::string& points) const {
    Series series = whole;
    if (series.max_points == 0 || series.max_points > kMostPoints) {
      series.max_points = kMostPoints;
    }
    series = Downsample(series, panel_.x.log);
    const auto parts = PartsOf(series);
    SvgPath line;
    SvgPath alone;  // points between two gaps, which no line shows
    SvgPath shapes;
    for (const std::vector<Place>& part : parts) {
      SvgPath& path = part.size() > 1 ? line : alone;
      path.MoveTo(X(part[0].x), Y(series.y[part[0].i]));
      for (std::size_t n = 1; n < part.size(); ++n) {
        path.LineTo(X(part[n].x), Y(series.y[part[n].i]));
      }
      if (part.size() == 1) path.LineTo(X(part[0].x), Y(series.y[part[0].i]));
    }
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!IsInside(series.x[i], series.y[i])) continue;
      shapes.AddShape(series.style.marker, X(series.x[i]), Y(series.y[i]),
                      series.style.marker_size_pt);
    }
    const std::string group =
        absl::StrCat("<g ", Paint(series.style.colour, "series "), ">\n",
                     Title(series.label));
    if (series.style.marker != MarkerShape::kNone && !shapes.empty()) {
      absl::StrAppend(&points, group, Shapes(shapes, series.style), "</g>\n");
    }
    std::string drawn = Band(series, parts);
    if (series.style.line != LineStyle::kNone) {
      drawn += Line(line, series.style);
      if (series.style.marker == MarkerShape::kNone) {
        drawn += Stroked(alone, std::max(2.0 * series.style.width_pt, 2.4),
                         " stroke-linecap=\"round\"");
      }
    }
    return drawn.empty() ? "" : absl::StrCat(group, drawn, "</g>\n");
  }

  const Panel& panel_;
  const PanelLayout& placed_;
  const double width_;
  const double height_;
};

// <g class="panel">, as svg.h says.
std::string SvgPanel(const Panel& panel, const PanelLayout& placed,
                     double figure_height_pt) {
  return PanelWriter(panel, placed).Write(figure_height_pt);
}

constexpr double kPixelsPerPoint = 96.0 / 72.0;
constexpr double kLargestScale = 1.4;
// Below this the text is too small to read on a telephone: the page lets the
// picture be scrolled instead.
constexpr double kSmallestScale = 0.85;
std::string TextOf(const PlacedText& text, const Figure& figure,
                   double figure_height) {
  constexpr double kHalfCapital = 0.36;  // of the font size
  const std::string x = Coordinate(text.x);
  const double middle = figure_height - text.y;
  const double down = kHalfCapital * text.size_pt;
  std::string out = text.upright
                        ? absl::StrCat("<text transform=\"translate(", x, " ",
                                       Coordinate(middle), ") rotate(-90)\"",
                                       Attribute("y", down))
                        : absl::StrCat("<text", Attribute("x", text.x),
                                       Attribute("y", middle + down));
  if (text.align == TextAlign::kCenter) out += " text-anchor=\"middle\"";
  if (text.align == TextAlign::kRight) out += " text-anchor=\"end\"";
  if (text.size_pt != figure.font_size_pt) {
    out += Attribute("font-size", text.size_pt);
  }
  return absl::StrCat(out, ">", EscapeHtml(text.text), "</text>\n");
}

std::string LegendOf(const LegendSample& sample, const Figure& figure,
                     double figure_height) {
  const double y = figure_height - sample.y;
  const double half_band = 0.35 * figure.font_size_pt;
  std::string out =
      absl::StrCat("<g ", Paint(sample.style.colour, "sample "), ">\n");
  if (sample.band) {
    out +=
        Rectangle(sample.x_begin, y - half_band, sample.x_end - sample.x_begin,
                  2.0 * half_band, " fill-opacity=\"0.2\"");
  }
  if (sample.style.line != LineStyle::kNone) {
    SvgPath path;
    path.AddLine(sample.x_begin, y, sample.x_end, y);
    out += Line(path, sample.style);
  }
  if (sample.style.marker != MarkerShape::kNone) {
    SvgPath path;
    path.AddShape(sample.style.marker, 0.5 * (sample.x_begin + sample.x_end), y,
                  sample.style.marker_size_pt);
    out += Shapes(path, sample.style);
  }
  return out + "</g>\n";
}

// All between <svg> and </svg>.
std::string Content(const Figure& figure, const Layout& layout) {
  std::string out = Rectangle(0.0, 0.0, layout.width_pt, layout.height_pt,
                              " " + Paint(kGround));
  for (std::size_t i = 0; i < layout.panels.size(); ++i) {
    out += SvgPanel(figure.panels[i], layout.panels[i], layout.height_pt);
  }
  for (const LegendSample& sample : layout.legend) {
    out += LegendOf(sample, figure, layout.height_pt);
  }
  absl::StrAppend(&out, "<g ", Paint(kInk), " fill=\"currentColor\">\n");
  for (const PlacedText& text : layout.texts) {
    out += TextOf(text, figure, layout.height_pt);
  }
  return out + "</g>\n";
}

// Viewers without DejaVu Sans take the next font, not one with serifs.
std::string OpeningTag(const Figure& figure, const Layout& layout) {
  return absl::StrCat(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"drawing\" "
      "role=\"img\" viewBox=\"0 0 ",
      Coordinate(layout.width_pt), " ", Coordinate(layout.height_pt),
      "\" font-family=\"", kFont, ", Verdana, Helvetica, Arial, sans-serif\"",
      Attribute("font-size", figure.font_size_pt));
}

}  // namespace

absl::StatusOr<std::string> SvgFile(const Figure& figure,
                                    std::string_view title,
                                    std::string_view description) {
  MLE_ASSIGN_OR_RETURN(const Layout layout, MakeLayout(figure));
  return absl::StrCat(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
      OpeningTag(figure, layout), " width=\"", Coordinate(layout.width_pt),
      "pt\" height=\"", Coordinate(layout.height_pt), "pt\">\n<title>",
      EscapeHtml(title), "</title>\n<desc>", EscapeHtml(description),
      "</desc>\n<style>", FigureStyle(), "</style>\n", Content(figure, layout),
      "</svg>\n");
}

absl::StatusOr<std::string> SvgElement(const Figure& figure,
                                       std::string_view description) {
  MLE_ASSIGN_OR_RETURN(const Layout layout, MakeLayout(figure));
  const double width = kPixelsPerPoint * layout.width_pt;
  return absl::StrCat(
      OpeningTag(figure, layout), " aria-label=\"", EscapeHtml(description),
      "\" style=\"max-width:", std::lround(kLargestScale * width),
      "px;min-width:", std::lround(kSmallestScale * width), "px\">\n",
      Content(figure, layout), "</svg>\n");
}

std::string FigureStyle() {
  std::string out = "\n@media screen and (prefers-color-scheme: dark) {\n";
  for (const SvgColour& colour : {kInk, kAxis, kGrid, kGround, kCell}) {
    absl::StrAppend(&out, ".drawing .", colour.name, " { color: ", colour.dark,
                    "; }\n");
  }
  for (const Role role : AllRoles()) {
    absl::StrAppend(&out, ".drawing .role-", NameOf(role),
                    " { color: ", DarkColourOf(role), "; }\n");
  }
  return out + "}\n";
}

}  // namespace mle::report
