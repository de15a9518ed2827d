#include "apps/report/chart_data.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

// Longer series are thinned to about this many points, whatever they ask for.
constexpr int kMostPoints = 4000;
// Points of print are smaller than pixels of a screen.
constexpr double kPixelsPerPoint = 1.6;

std::string Quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : CleanText(text)) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '<' || c == '>' || c == '&') {
      absl::StrAppendFormat(&out, "\\u%04x", static_cast<int>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string Number(double value) {
  return std::isfinite(value) ? absl::StrFormat("%.7g", value) : "null";
}

std::string Numbers(const std::vector<double>& values) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out += ',';
    out += Number(values[i]);
  }
  return out + ']';
}

std::string_view Dash(LineStyle line) {
  switch (line) {
    case LineStyle::kDashed:
      return "[7,4]";
    case LineStyle::kDotted:
      return "[2,3]";
    case LineStyle::kDashDotted:
      return "[8,3,2,3]";
    case LineStyle::kNone:
    case LineStyle::kSolid:
      break;
  }
  return "[]";
}

std::string_view Shape(MarkerShape shape) {
  switch (shape) {
    case MarkerShape::kNone:
      return "";
    case MarkerShape::kCross:
      return "cross";
    case MarkerShape::kPlus:
      return "plus";
    case MarkerShape::kCircle:
      return "circle";
    case MarkerShape::kDisc:
      return "disc";
    case MarkerShape::kSquare:
      return "square";
    case MarkerShape::kDiamond:
      return "diamond";
    case MarkerShape::kTriangle:
      return "triangle";
  }
  return "";
}

std::string Look(const std::string& label, const Style& style) {
  return absl::StrCat(
      "\"label\":", Quoted(label), ",\"colour\":\"", NameOf(style.colour),
      "\",\"line\":", style.line == LineStyle::kNone ? "false" : "true",
      ",\"dash\":", std::string(Dash(style.line)),
      ",\"width\":", Number(kPixelsPerPoint * style.width_pt), ",\"marker\":\"",
      std::string(Shape(style.marker)),
      "\",\"size\":", Number(kPixelsPerPoint * style.marker_size_pt));
}

// Without the points in the middle of a stair, which say nothing.
Series WithoutRepetitions(const Series& stairs) {
  Series kept = stairs;
  kept.x.clear();
  kept.y.clear();
  const auto last = static_cast<std::ptrdiff_t>(stairs.y.size()) - 1;
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    const bool repeats = i > 0 && i < last && stairs.y[i] == stairs.y[i - 1] &&
                         stairs.y[i] == stairs.y[i + 1];
    if (repeats) continue;
    kept.x.push_back(stairs.x[i]);
    kept.y.push_back(stairs.y[i]);
  }
  return kept;
}

std::string SeriesData(const Series& series, bool log_x) {
  Series thinned = series.steps && series.lower.empty()
                       ? WithoutRepetitions(series)
                       : series;
  if (thinned.max_points == 0 || thinned.max_points > kMostPoints) {
    thinned.max_points = kMostPoints;
  }
  thinned = Downsample(thinned, log_x);
  std::string out = absl::StrCat("{", Look(series.label, series.style),
                                 ",\"steps\":", series.steps ? "true" : "false",
                                 ",\"x\":", Numbers(thinned.x),
                                 ",\"y\":", Numbers(thinned.y));
  if (!thinned.lower.empty()) {
    absl::StrAppend(&out, ",\"lower\":", Numbers(thinned.lower),
                    ",\"upper\":", Numbers(thinned.upper));
  }
  return out + "}";
}

std::string MarkerData(const Marker& marker) {
  Style style = marker.style;
  style.line = LineStyle::kNone;
  return absl::StrCat("{", Look(marker.label, style),
                      ",\"steps\":false,\"x\":[", Number(marker.x), "],\"y\":[",
                      Number(marker.y), "]}");
}

// [written(item),…]
template <typename Items, typename Write>
std::string Joined(const Items& items, const Write& written) {
  std::string out = "[";
  for (const auto& item : items) {
    absl::StrAppend(&out, out.size() > 1 ? "," : "", written(item));
  }
  return out + "]";
}

std::string AxisData(const Axis& axis) {
  // What stands before a value: the label without its unit.
  const std::string name = axis.label.substr(0, axis.label.find(" ("));
  return absl::StrCat(
      "{\"label\":", Quoted(axis.label), ",\"name\":", Quoted(name),
      ",\"log\":", axis.log ? "true" : "false",
      ",\"names\":", Joined(axis.names, Quoted), ",\"range\":",
      axis.range ? absl::StrCat("[", Number(axis.range->min), ",",
                                Number(axis.range->max), "]")
                 : std::string("null"),
      "}");
}

std::string LineData(const ReferenceLine& line) {
  return absl::StrCat(
      "{", Look(line.label, line.style), ",\"vertical\":",
      line.orientation == Orientation::kVertical ? "true" : "false",
      ",\"value\":", Number(line.value), "}");
}

std::string SpanData(const Span& span) {
  return absl::StrCat("{", Look(span.label, span.style), ",\"shaded\":true",
                      ",\"from\":", Number(span.from),
                      ",\"to\":", Number(span.to), "}");
}

std::string PanelData(const Panel& panel, const Axis& x, const Axis& y) {
  std::vector<std::string> series;
  for (const Series& s : panel.series) {
    series.push_back(SeriesData(s, panel.x.log));
  }
  for (const Marker& marker : panel.markers) {
    if (std::isfinite(marker.x) && std::isfinite(marker.y)) {
      series.push_back(MarkerData(marker));
    }
  }
  std::vector<ReferenceLine> lines;
  for (const ReferenceLine& line : panel.lines) {
    if (std::isfinite(line.value)) lines.push_back(line);
  }
  const auto as_is = [](const std::string& text) { return text; };
  return absl::StrCat("{\"title\":", Quoted(panel.title),
                      ",\"x\":", AxisData(x), ",\"y\":", AxisData(y),
                      ",\"series\":", Joined(series, as_is),
                      ",\"lines\":", Joined(lines, LineData),
                      ",\"spans\":", Joined(panel.spans, SpanData), "}");
}

}  // namespace

std::string ChartData(const Figure& figure) {
  std::string out = absl::StrCat(
      "{\"columns\":", figure.columns,
      ",\"legend\":", figure.legend ? "true" : "false", ",\"panels\":[");
  // Panels above others leave the label of x to the lowest, those to the right
  // that of y to the first.
  const auto count = static_cast<int>(figure.panels.size());
  for (int i = 0; i < count; ++i) {
    int lowest = i;
    while (lowest + figure.columns < count) lowest += figure.columns;
    Axis x = figure.panels[i].x;
    if (x.label.empty()) x.label = figure.panels[lowest].x.label;
    Axis y = figure.panels[i].y;
    if (y.label.empty()) {
      y.label = figure.panels[i - i % figure.columns].y.label;
    }
    absl::StrAppend(&out, i > 0 ? "," : "", PanelData(figure.panels[i], x, y));
  }
  return out + "]}";
}

}  // namespace mle::report
