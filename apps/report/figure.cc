#include "apps/report/figure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "mle/base/status.h"

namespace mle::report {
namespace {

bool InRange(double value, double low, double high) {
  return value >= low && value <= high;  // false for NaN
}

absl::Status InvalidIf(bool wrong, absl::string_view where,
                       absl::string_view what) {
  if (!wrong) return absl::OkStatus();
  return InvalidArgument(where, ": ", what);
}

absl::Status ValidateAxis(const Axis& axis, const std::string& where) {
  if (axis.dates.has_value()) {
    const bool is_scale = std::isfinite(axis.dates->origin) &&
                          std::isfinite(axis.dates->seconds_per_unit) &&
                          axis.dates->seconds_per_unit > 0.0;
    if (const absl::Status status =
            InvalidIf(axis.log || !axis.names.empty() || !is_scale, where,
                      "an axis of dates has a finite origin, a positive unit, "
                      "no names and no logarithm");
        !status.ok()) {
      return status;
    }
  }
  if (!axis.names.empty()) {
    return InvalidIf(axis.log || axis.range.has_value(), where,
                     "an axis with names has no range and no logarithm");
  }
  if (!axis.range.has_value()) return absl::OkStatus();
  const Range& range = *axis.range;
  const bool ordered = std::isfinite(range.min) && std::isfinite(range.max) &&
                       range.min < range.max;
  const bool positive = !axis.log || range.min > 0.0;
  return InvalidIf(
      !ordered || !positive, where,
      absl::StrCat("the range is ", range.min, " … ", range.max,
                   "; it must be finite, with min < max",
                   axis.log ? " and min > 0 on a logarithmic axis" : ""));
}

absl::Status ValidateStyle(const Style& style, const std::string& where) {
  const bool good = InRange(style.width_pt, 0.0, 50.0) &&
                    InRange(style.marker_size_pt, 0.0, 200.0);
  return InvalidIf(!good, where,
                   absl::StrCat("width_pt is ", style.width_pt,
                                " and marker_size_pt ", style.marker_size_pt,
                                "; they must lie in [0, 50] and [0, 200]"));
}

absl::Status ValidateSeries(const Series& series, const std::string& where) {
  const std::size_t n = series.x.size();
  absl::Status status = ValidateStyle(series.style, where);
  status.Update(
      InvalidIf(series.y.size() != n, where,
                absl::StrCat("x has ", n, " points and y ", series.y.size())));
  const bool no_band = series.lower.empty() && series.upper.empty();
  status.Update(InvalidIf(
      !no_band && (series.lower.size() != n || series.upper.size() != n), where,
      absl::StrCat("the band has ", series.lower.size(), " lower and ",
                   series.upper.size(), " upper points; both must be ", n,
                   " or none")));
  status.Update(
      InvalidIf(series.max_points != 0 && series.max_points < 6, where,
                absl::StrCat("max_points is ", series.max_points,
                             "; it must be 0 (all points) or at least 6")));
  return status;
}

absl::Status ValidatePanel(const Panel& panel, const std::string& where) {
  absl::Status status = ValidateAxis(panel.x, absl::StrCat(where, ", x axis"));
  status.Update(ValidateAxis(panel.y, absl::StrCat(where, ", y axis")));
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    status.Update(ValidateSeries(
        series,
        absl::StrCat(where, ", series ", i + 1, " \"", series.label, "\"")));
  }
  for (const ReferenceLine& line : panel.lines) {
    status.Update(ValidateStyle(
        line.style, absl::StrCat(where, ", line \"", line.label, "\"")));
  }
  for (const Marker& marker : panel.markers) {
    status.Update(ValidateStyle(
        marker.style, absl::StrCat(where, ", marker \"", marker.label, "\"")));
  }
  for (const Span& span : panel.spans) {
    status.Update(
        InvalidIf(!(std::isfinite(span.from) && std::isfinite(span.to) &&
                    span.from < span.to),
                  absl::StrCat(where, ", span \"", span.label, "\""),
                  absl::StrCat("it goes from ", span.from, " to ", span.to,
                               "; both must be finite, in this order")));
  }
  for (const Cell& cell : panel.cells) {
    status.Update(InvalidIf(
        !(std::isfinite(cell.x) && std::isfinite(cell.y) &&
          InRange(cell.shade, 0.0, 1.0)),
        absl::StrCat(where, ", cell at ", cell.x, ", ", cell.y),
        absl::StrCat("its shade is ", cell.shade,
                     "; it must lie in [0, 1], its place be finite")));
  }
  return status;
}

// The number, from 0 to count − 1, of the stretch each x lies in; what has no
// place on the axis lies in the stretch of its neighbour before.
std::vector<int> Stretches(const std::vector<double>& x, bool log, int count) {
  const auto place = [log](double value) {
    return log ? std::log(value) : value;
  };
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : x) {
    if (!std::isfinite(place(value))) continue;
    low = std::min(low, place(value));
    high = std::max(high, place(value));
  }
  std::vector<int> stretches;
  int last = 0;
  for (const double value : x) {
    if (std::isfinite(place(value)) && high > low) {
      const double fraction = (place(value) - low) / (high - low);
      last = std::min(count - 1, static_cast<int>(count * fraction));
    }
    stretches.push_back(last);
  }
  return stretches;
}

}  // namespace

namespace {

// The look of each role, in the order of Role; the colour of a style is its
// role's.
struct Look {
  const char* name;
  const char* colour;
  const char* dark;
  Style style = {};
};
constexpr Look kLooks[] = {
    {"initial", "#000000", "#e4e8ec", {.line = LineStyle::kDashed}},
    {"true", "#e69f00", "#e69f00", {.width_pt = 3.0}},           // orange
    {"corrected", "#0072b2", "#4ba6e0", {.width_pt = 1.25}},     // blue
    {"unregularised", "#d55e00", "#f2803a", {.width_pt = 0.5}},  // vermilion
    {"fitted",
     "#cc79a7",
     "#dc9cc0",
     {.line = LineStyle::kDashDotted}},  // purple
    {"alternative",
     "#009e73",
     "#2fc79b",
     {.line = LineStyle::kDashed}},                          // green
    {"measured", "#56b4e9", "#8a97a3", {.width_pt = 0.75}},  // sky blue
    {"set-point", "#000000", "#e4e8ec", {.line = LineStyle::kDotted}},
    {"reference", "#666666", "#a4afba", {.line = LineStyle::kDotted}},
    {"chosen",
     "#d55e00",
     "#f2803a",
     {.width_pt = 1.5, .marker = MarkerShape::kCross, .marker_size_pt = 6.0}},
    {"best",
     "#009e73",
     "#2fc79b",
     {.width_pt = 1.25, .marker = MarkerShape::kCircle, .marker_size_pt = 6.0}},
    {"unused",
     "#8a8a8a",
     "#8a939c",
     {.line = LineStyle::kNone,
      .marker = MarkerShape::kCross,
      .marker_size_pt = 4.0}},
    {"window", "#e69f00", "#e69f00"},
};

const Look& LookOf(Role role) { return kLooks[static_cast<int>(role)]; }
}  // namespace
std::string ColourOf(Role role) { return LookOf(role).colour; }
std::string DarkColourOf(Role role) { return LookOf(role).dark; }
std::string NameOf(Role role) { return LookOf(role).name; }
const std::vector<Role>& AllRoles() {
  static const std::vector<Role>* const kRoles = [] {
    auto* all = new std::vector<Role>;
    for (std::size_t i = 0; i < std::size(kLooks); ++i) {
      all->push_back(static_cast<Role>(i));
    }
    return all;
  }();
  return *kRoles;
}
Style StyleOf(Role role) {
  Style style = LookOf(role).style;
  style.colour = role;
  return style;
}

Panel& Figure::AddPanel(std::string panel_title) {
  Panel panel;
  panel.title = std::move(panel_title);
  panels.push_back(std::move(panel));
  return panels.back();
}

absl::Status Figure::Validate() const {
  absl::Status status = InvalidIf(
      !InRange(width_cm, 3.0, 100.0) || !InRange(height_cm, 3.0, 100.0),
      "figure",
      absl::StrCat("the size is ", width_cm, " cm × ", height_cm,
                   " cm; both must lie in [3, 100]"));
  status.Update(InvalidIf(!InRange(font_size_pt, 4.0, 40.0), "figure",
                          absl::StrCat("font_size_pt is ", font_size_pt,
                                       "; it must lie in [4, 40]")));
  status.Update(InvalidIf(
      columns < 1, "figure",
      absl::StrCat("columns is ", columns, "; it must be at least 1")));
  status.Update(InvalidIf(panels.empty(), "figure", "it has no panel"));
  for (std::size_t i = 0; i < panels.size(); ++i) {
    status.Update(ValidatePanel(
        panels[i],
        absl::StrCat("panel ", i + 1, " \"", panels[i].title, "\"")));
  }
  return status;
}

Series MakeSeries(Role role, std::string label, std::vector<double> x,
                  std::vector<double> y) {
  Series series;
  series.label = std::move(label);
  series.x = std::move(x);
  series.y = std::move(y);
  series.style = StyleOf(role);
  return series;
}

ReferenceLine HorizontalLine(Role role, std::string label, double y) {
  return {std::move(label), Orientation::kHorizontal, y, StyleOf(role)};
}

ReferenceLine VerticalLine(Role role, std::string label, double x) {
  return {std::move(label), Orientation::kVertical, x, StyleOf(role)};
}

Marker MakeMarker(Role role, std::string label, double x, double y) {
  Style style = StyleOf(role);
  if (style.marker == MarkerShape::kNone) style.marker = MarkerShape::kDisc;
  return {std::move(label), x, y, style};
}

Span MakeSpan(Role role, std::string label, double from, double to) {
  return {std::move(label), from, to, StyleOf(role)};
}

Series Downsample(const Series& series, bool log_x) {
  const std::size_t n = series.x.size();
  const std::size_t most = static_cast<std::size_t>(series.max_points);
  if (most == 0 || n <= most) return series;

  // Each segment keeps its smallest value, its largest, and a break if there is
  // one.
  std::vector<std::size_t> kept = {0, n - 1};
  const std::vector<int> stretch =
      Stretches(series.x, log_x, static_cast<int>((most - 2) / 2));
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    std::size_t low = n;
    std::size_t high = n;
    std::size_t gap = n;
    for (end = begin; end < n && stretch[end] == stretch[begin]; ++end) {
      if (!std::isfinite(series.x[end]) || !std::isfinite(series.y[end])) {
        gap = end;
        continue;
      }
      if (low == n || series.y[end] < series.y[low]) low = end;
      if (high == n || series.y[end] > series.y[high]) high = end;
    }
    for (const std::size_t i : {low, high, gap}) {
      if (i != n) kept.push_back(i);
    }
  }
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());

  Series out = series;
  const auto pick = [&kept](const std::vector<double>& from) {
    std::vector<double> to;
    if (from.empty()) return to;
    for (const std::size_t i : kept) to.push_back(from[i]);
    return to;
  };
  out.x = pick(series.x);
  out.y = pick(series.y);
  out.lower = pick(series.lower);
  out.upper = pick(series.upper);
  return out;
}

}  // namespace mle::report
