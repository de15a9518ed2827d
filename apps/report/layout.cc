#include "apps/report/layout.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/status/status.h"
#include "apps/report/text.h"
#include "mle/base/status.h"

namespace mle::report {
namespace {

constexpr double kPointsPerCm = 72.0 / 2.54;

// Distances in units of the font size.
constexpr double kEdge = 0.4;          // free around the figure
constexpr double kTickGap = 0.55;      // from frame to tick label
constexpr double kLine = 1.35;         // from line to line of text
constexpr double kLabelGap = 0.3;      // from tick labels to an upright label
constexpr double kPanelGap = 0.9;      // between neighbouring panels
constexpr double kTickSize = 0.9;      // size of the tick labels
constexpr double kTitleSize = 1.15;    // size of the figure's title
constexpr double kLineSample = 2.4;    // length of a line in the legend
constexpr double kMarkerSample = 1.0;  // room for a marker in the legend
constexpr double kSampleGap = 0.5;     // from sample to its text
constexpr double kEntryGap = 1.6;      // between entries of the legend
constexpr double kLegendGap = 0.35;    // from legend to panels
constexpr double kLegendLine = 1.5;    // from line to line of the legend
constexpr double kLongestName = 16.0;  // of a place on an axis

// Room around a frame, in points.
struct Margins {
  double left = 0.0;
  double right = 0.0;
  double bottom = 0.0;
  double top = 0.0;
};

struct LegendEntry {
  std::string label;
  Style style;
  bool band = false;
};

bool HasShownPoint(const Series& series, const Panel& panel) {
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (IsShown(series.x[i], panel.x.log) &&
        IsShown(series.y[i], panel.y.log)) {
      return true;
    }
  }
  return false;
}

std::vector<LegendEntry> CollectLegend(const Figure& figure) {
  std::vector<LegendEntry> entries;
  std::set<std::string> seen;
  const auto add = [&](const std::string& label, const Style& style, bool band,
                       bool shown) {
    if (label.empty() || !shown || !seen.insert(label).second) return;
    entries.push_back({label, style, band});
  };
  if (!figure.legend) return entries;
  for (const Panel& panel : figure.panels) {
    for (const Series& series : panel.series) {
      add(series.label, series.style, !series.lower.empty(),
          HasShownPoint(series, panel));
    }
    for (const Span& span : panel.spans) {
      Style style = span.style;
      style.line = LineStyle::kNone;
      style.marker = MarkerShape::kNone;
      add(span.label, style, true, true);
    }
    for (const ReferenceLine& line : panel.lines) {
      const bool log = line.orientation == Orientation::kVertical ? panel.x.log
                                                                  : panel.y.log;
      add(line.label, line.style, false, IsShown(line.value, log));
    }
  }
  for (const Panel& panel : figure.panels) {
    for (const Marker& marker : panel.markers) {
      Style style = marker.style;
      style.line = LineStyle::kNone;
      add(marker.label, style, false,
          IsShown(marker.x, panel.x.log) && IsShown(marker.y, panel.y.log));
    }
  }
  return entries;
}

// Puts the entries into as many centred lines as they need, from `top` down.
// Returns the height used.
double PlaceLegend(const Figure& figure, double top, Layout& layout) {
  const double em = figure.font_size_pt;
  const double room = layout.width_pt / em - 2.0 * kEdge;
  struct Sized {
    LegendEntry entry;
    double sample;
    double width;
  };
  std::vector<std::vector<Sized>> lines;
  double used = room;  // the first entry opens a line
  for (LegendEntry& entry : CollectLegend(figure)) {
    const bool point = entry.style.line == LineStyle::kNone && !entry.band;
    const double sample = point ? kMarkerSample : kLineSample;
    entry.label = Ellipsized(entry.label, room - sample - kSampleGap);
    const double width = sample + kSampleGap + TextWidth(entry.label);
    if (used + kEntryGap + width > room) {
      lines.emplace_back();
      used = width;
    } else {
      used += kEntryGap + width;
    }
    lines.back().push_back({std::move(entry), sample, width});
  }

  double y = top - 0.5 * kLegendLine * em;
  for (const auto& line : lines) {
    double width = kEntryGap * static_cast<double>(line.size() - 1);
    for (const Sized& sized : line) width += sized.width;
    double x = 0.5 * (layout.width_pt - width * em);
    for (const Sized& sized : line) {
      const double end = x + sized.sample * em;
      layout.legend.push_back({sized.entry.style, sized.entry.band, x, end, y});
      layout.texts.push_back({sized.entry.label, end + kSampleGap * em, y,
                              TextAlign::kLeft, em, false});
      x += (sized.width + kEntryGap) * em;
    }
    y -= kLegendLine * em;
  }
  if (lines.empty()) return 0.0;
  return (kLegendLine * static_cast<double>(lines.size()) + kLegendGap) * em;
}

double WidestLabel(const std::vector<Tick>& ticks) {
  double widest = 0.0;
  for (const Tick& tick : ticks) {
    widest = std::max(widest, TextWidth(tick.label));
  }
  return widest;
}

// Ticks so many that their labels have room on `length` points.
std::vector<Tick> FittingTicks(const Axis& axis, const Range& range, double em,
                               double length, bool horizontal) {
  const auto some = [&](int wanted) {
    return axis.dates.has_value() ? DateTicks(range, *axis.dates, wanted)
                                  : Ticks(range, axis.log, wanted);
  };
  for (int wanted = 7; wanted > 2; --wanted) {
    std::vector<Tick> ticks = some(wanted);
    double needed = 0.0;
    for (const Tick& tick : ticks) {
      if (tick.label.empty()) continue;
      needed += em * (horizontal ? kTickSize * TextWidth(tick.label) + 1.0
                                 : 1.8 * kTickSize);
    }
    if (needed <= length) return ticks;
  }
  return some(2);
}

std::vector<Tick> TicksOf(const Axis& axis, const Range& range, double em,
                          double length, bool horizontal, int places) {
  if (axis.names.empty()) {
    return FittingTicks(axis, range, em, length, horizontal);
  }
  std::vector<Tick> ticks = NamedTicks(axis.names);
  const double room = horizontal
                          ? length / em / kTickSize / std::max(places, 1) - 1.0
                          : kLongestName;
  for (Tick& tick : ticks) tick.label = Ellipsized(tick.label, room);
  return ticks;
}

Margins MarginsOf(const Panel& panel, const PanelLayout& placed, double em) {
  Margins margins;
  margins.left = kTickGap + kTickSize * WidestLabel(placed.y_ticks) +
                 (panel.y.label.empty() ? 0.0 : kLine + kLabelGap);
  margins.bottom = kTickGap + kTickSize + (panel.x.label.empty() ? 0.0 : kLine);
  margins.top = panel.title.empty() ? 0.5 * kTickSize : kLine + 0.15;
  // The last label below the axis may stand out by half its width.
  for (const Tick& tick : placed.x_ticks) {
    const double beyond =
        Fraction(tick.value, placed.x_range, panel.x.log) > 0.9
            ? 0.5 * kTickSize * TextWidth(tick.label)
            : 0.0;
    margins.right = std::max(margins.right, beyond);
  }
  return {margins.left * em, margins.right * em, margins.bottom * em,
          margins.top * em};
}

// Rows and columns of equally large frames between `top` and the lower edge.
absl::Status PlaceFrames(const Figure& figure, double top, Layout& layout) {
  const double em = figure.font_size_pt;
  const int count = static_cast<int>(figure.panels.size());
  const int columns = std::min(figure.columns, count);
  const int rows = (count + columns - 1) / columns;
  const double room_x =
      layout.width_pt - 2.0 * kEdge * em - (columns - 1) * kPanelGap * em;
  const double room_y = top - kEdge * em - (rows - 1) * kPanelGap * em;

  std::vector<Margins> by_column(columns);
  std::vector<Margins> by_row(rows);
  for (int i = 0; i < count; ++i) {
    const Panel& panel = figure.panels[i];
    PanelLayout& placed = layout.panels[i];
    placed.x_range = XRange(panel);
    placed.y_range = YRange(panel);
    const auto places = static_cast<int>(panel.x.names.size());
    placed.x_ticks = TicksOf(panel.x, placed.x_range, em,
                             0.8 * room_x / columns, true, places);
    placed.y_ticks = TicksOf(panel.y, placed.y_range, em,
                             0.8 * room_y / rows - 2.0 * em, false, 0);
    const Margins margins = MarginsOf(panel, placed, em);
    Margins& column = by_column[i % columns];
    Margins& row = by_row[i / columns];
    column.left = std::max(column.left, margins.left);
    column.right = std::max(column.right, margins.right);
    row.bottom = std::max(row.bottom, margins.bottom);
    row.top = std::max(row.top, margins.top);
  }

  double width = room_x;
  for (const Margins& m : by_column) width -= m.left + m.right;
  double height = room_y;
  for (const Margins& m : by_row) height -= m.bottom + m.top;
  width /= columns;
  height /= rows;
  if (width < 3.0 * em || height < 2.0 * em) {
    return InvalidArgument("figure: ", figure.width_cm, " cm × ",
                           figure.height_cm, " cm is too small for ", rows,
                           " × ", columns, " panels with their labels in ",
                           figure.font_size_pt, " pt");
  }

  double y = top;
  for (int r = 0; r < rows; ++r) {
    y -= by_row[r].top + height;
    double x = kEdge * em;
    for (int c = 0; c < columns; ++c) {
      x += by_column[c].left;
      if (const int i = r * columns + c; i < count) {
        layout.panels[i].frame = {x, x + width, y, y + height};
        layout.panels[i].y_label_x = x - by_column[c].left + 0.5 * kLine * em;
      }
      x += width + by_column[c].right + kPanelGap * em;
    }
    y -= by_row[r].bottom + kPanelGap * em;
  }
  return absl::OkStatus();
}

// The words of each cell, from its middle up and down.
void PlaceCellTexts(const Panel& panel, const PanelLayout& placed, double em,
                    Layout& layout) {
  const Frame& frame = placed.frame;
  const double width = frame.right - frame.left;
  const double height = frame.top - frame.bottom;
  const double size = kTickSize * em;
  const double room =
      width / (placed.x_range.max - placed.x_range.min) / size - 0.6;
  for (const Cell& cell : panel.cells) {
    const double x =
        frame.left + width * Fraction(cell.x, placed.x_range, false);
    const double y =
        frame.bottom + height * Fraction(cell.y, placed.y_range, false);
    const auto count = static_cast<double>(cell.lines.size());
    for (std::size_t n = 0; n < cell.lines.size(); ++n) {
      const double below = static_cast<double>(n) - 0.5 * (count - 1.0);
      layout.texts.push_back({Ellipsized(cell.lines[n], room), x,
                              y - kLine * size * below, TextAlign::kCenter,
                              size, false});
    }
  }
}

void PlacePanelTexts(const Panel& panel, const PanelLayout& placed, double em,
                     Layout& layout) {
  const Frame& frame = placed.frame;
  const double width = frame.right - frame.left;
  const double height = frame.top - frame.bottom;
  const double tick_size = kTickSize * em;
  const double tick_y = frame.bottom - (kTickGap + 0.5 * kTickSize) * em;
  const double tick_x = frame.left - kTickGap * em;
  for (const Tick& tick : placed.x_ticks) {
    if (tick.label.empty()) continue;
    const double x =
        frame.left + width * Fraction(tick.value, placed.x_range, panel.x.log);
    layout.texts.push_back(
        {tick.label, x, tick_y, TextAlign::kCenter, tick_size, false});
  }
  for (const Tick& tick : placed.y_ticks) {
    if (tick.label.empty()) continue;
    const double y = frame.bottom +
                     height * Fraction(tick.value, placed.y_range, panel.y.log);
    layout.texts.push_back(
        {tick.label, tick_x, y, TextAlign::kRight, tick_size, false});
  }
  const double mid_x = 0.5 * (frame.left + frame.right);
  const double mid_y = 0.5 * (frame.bottom + frame.top);
  const auto add = [&](const std::string& text, double room, double x, double y,
                       TextAlign align, bool upright) {
    if (text.empty()) return;
    layout.texts.push_back(
        {Ellipsized(text, room / em), x, y, align, em, upright});
  };
  add(panel.title, width, frame.left, frame.top + 0.75 * em, TextAlign::kLeft,
      false);
  add(panel.x.label, width, mid_x,
      frame.bottom - (kTickGap + kTickSize + 0.5 * kLine) * em,
      TextAlign::kCenter, false);
  add(panel.y.label, height + em, placed.y_label_x, mid_y, TextAlign::kCenter,
      true);
  const bool empty =
      std::none_of(panel.series.begin(), panel.series.end(),
                   [&](const Series& s) { return HasShownPoint(s, panel); });
  if (empty && panel.lines.empty() && panel.markers.empty() &&
      panel.cells.empty()) {
    add("no data", width, mid_x, mid_y, TextAlign::kCenter, false);
  }
}

}  // namespace

absl::StatusOr<Layout> MakeLayout(const Figure& figure) {
  MLE_RETURN_IF_ERROR(figure.Validate());
  const double em = figure.font_size_pt;
  Layout layout;
  layout.width_pt = figure.width_cm * kPointsPerCm;
  layout.height_pt = figure.height_cm * kPointsPerCm;
  layout.panels.resize(figure.panels.size());

  double top = layout.height_pt - 0.5 * kEdge * em;
  if (!figure.title.empty()) {
    const double room = layout.width_pt / em - 2.0 * kEdge;
    layout.texts.push_back({Ellipsized(figure.title, room / kTitleSize),
                            0.5 * layout.width_pt,
                            top - 0.5 * kLine * kTitleSize * em,
                            TextAlign::kCenter, kTitleSize * em, false});
    top -= kLine * kTitleSize * em;
  }
  top -= PlaceLegend(figure, top, layout);
  MLE_RETURN_IF_ERROR(PlaceFrames(figure, top, layout));
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    PlacePanelTexts(figure.panels[i], layout.panels[i], em, layout);
    PlaceCellTexts(figure.panels[i], layout.panels[i], em, layout);
  }
  return layout;
}

}  // namespace mle::report
