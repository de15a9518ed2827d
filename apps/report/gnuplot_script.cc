#include "apps/report/gnuplot_script.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/report/font.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

constexpr char kTextColour[] = "#222222";
constexpr char kFrameColour[] = "#555555";
constexpr char kGridColour[] = "#e2e2e2";

// The shortest decimals that read back as the same double, in any locale.
std::string Number(double value) {
  std::array<char, 40> buffer;
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return std::string(buffer.data(), end.ptr);
}

int PointType(MarkerShape shape) {
  switch (shape) {
    case MarkerShape::kNone:
      return 0;
    case MarkerShape::kPlus:
      return 1;
    case MarkerShape::kCross:
      return 2;
    case MarkerShape::kSquare:
      return 4;
    case MarkerShape::kCircle:
      return 6;
    case MarkerShape::kDisc:
      return 7;
    case MarkerShape::kTriangle:
      return 8;
    case MarkerShape::kDiamond:
      return 12;
  }
  return 0;
}

class ScriptWriter {
 public:
  ScriptWriter(const Figure& figure, const Layout& layout,
               const Terminal& terminal)
      : figure_(figure), layout_(layout), terminal_(terminal) {}

  std::string Write() {
    Add("set encoding utf8\nset terminal ", terminal_.name_and_size,
        " noenhanced font ", Font(figure_.font_size_pt), "\n");
    Add("set multiplot\nunset key\nset clip two\nset samples 2\n");
    for (std::size_t i = 0; i < layout_.panels.size(); ++i) {
      if (i + 1 == layout_.panels.size()) {
        AddTexts();
        AddLegend();
      }
      AddPanel(figure_.panels[i], layout_.panels[i]);
    }
    Add("unset multiplot\n");
    return std::move(script_);
  }

 private:
  template <typename... Parts>
  void Add(const Parts&... parts) {
    ((script_ += parts), ...);
  }

  std::string Font(double size_pt) const {
    return absl::StrCat("'", kFont, ",",
                        Number(size_pt * terminal_.font_per_pt), "'");
  }
  std::string Screen(double x_pt, double y_pt) const {
    return absl::StrCat("screen ", Number(x_pt / layout_.width_pt), ", screen ",
                        Number(y_pt / layout_.height_pt));
  }
  std::string LineWidth(double width_pt) const {
    return absl::StrCat("lw ", Number(width_pt * terminal_.line_per_pt));
  }
  std::string DashesOf(const Style& style) const;
  std::string LineOf(const Style& style) const;
  std::string PointOf(const Style& style) const;

  void AddPanel(const Panel& panel, const PanelLayout& placed);
  void AddAxis(const std::string& axis, bool log, const Range& range,
               const std::vector<Tick>& ticks);
  void AddReferenceLine(const Panel& panel, const PanelLayout& placed,
                        const ReferenceLine& line);
  void AddSpan(const PanelLayout& placed, const Span& span);
  void AddCell(const Cell& cell);
  void AddData(const Panel& panel, const Series& series,
               const std::string& name);
  void AddPlot(const Panel& panel);
  void AddTexts();
  void AddLegend();

  const Figure& figure_;
  const Layout& layout_;
  const Terminal& terminal_;
  std::string script_;
};

std::string ScriptWriter::DashesOf(const Style& style) const {
  // In points, on a line 1 pt wide or less; wider lines have longer dashes.
  std::vector<double> pattern;
  if (style.line == LineStyle::kDashed) pattern = {4.5, 2.5};
  if (style.line == LineStyle::kDotted) pattern = {1.2, 2.0};
  if (style.line == LineStyle::kDashDotted) pattern = {4.5, 2.0, 1.2, 2.0};
  if (pattern.empty() || style.width_pt == 0.0) return "solid";
  const double unit = terminal_.dash_length *
                      std::max(style.width_pt, terminal_.dash_min_width_pt);
  std::string dashes;
  for (const double length : pattern) {
    dashes += dashes.empty() ? "(" : ",";
    dashes += Number(length * std::max(style.width_pt, 1.0) / unit);
  }
  return dashes + ")";
}

std::string ScriptWriter::LineOf(const Style& style) const {
  return absl::StrCat("lc rgb '", ColourOf(style.colour), "' ",
                      LineWidth(style.width_pt), " dt ", DashesOf(style));
}

std::string ScriptWriter::PointOf(const Style& style) const {
  return absl::StrCat("pt ", PointType(style.marker), " ps ",
                      Number(style.marker_size_pt * terminal_.marker_per_pt));
}

void ScriptWriter::AddAxis(const std::string& axis, bool log,
                           const Range& range, const std::vector<Tick>& ticks) {
  Add(log ? "set logscale " : "unset logscale ", axis, "\n");
  Add("set ", axis, "range [", Number(range.min), ":", Number(range.max),
      "] noextend\n");
  Add("set ", axis, "tics out nomirror scale 0.5,0.3 textcolor rgb '",
      kTextColour, "' (");
  std::string_view comma = "";
  for (const Tick& tick : ticks) {
    // The labels are placed by the layout; level 1 is a minor tick.
    Add(comma, "'' ", Number(tick.value), tick.label.empty() ? " 1" : " 0");
    comma = ", ";
  }
  Add(")\n");
}

void ScriptWriter::AddReferenceLine(const Panel& panel,
                                    const PanelLayout& placed,
                                    const ReferenceLine& line) {
  const bool horizontal = line.orientation == Orientation::kHorizontal;
  const bool log = horizontal ? panel.y.log : panel.x.log;
  const Range& range = horizontal ? placed.y_range : placed.x_range;
  if (!IsShown(line.value, log)) return;
  if (line.value < range.min || line.value > range.max) return;
  const std::string value = Number(line.value);
  if (horizontal) {
    Add("set arrow from graph 0, first ", value, " to graph 1, first ", value);
  } else {
    Add("set arrow from first ", value, ", graph 0 to first ", value,
        ", graph 1");
  }
  Add(" nohead back ", LineOf(line.style), "\n");
}

void ScriptWriter::AddSpan(const PanelLayout& placed, const Span& span) {
  const double from = std::max(span.from, placed.x_range.min);
  const double to = std::min(span.to, placed.x_range.max);
  if (!(from < to)) return;
  Add("set object rectangle from first ", Number(from), ", graph 0 to first ",
      Number(to), ", graph 1 behind fs transparent solid 0.2 border lc rgb '",
      ColourOf(span.style.colour), "' fc rgb '", ColourOf(span.style.colour),
      "' ", LineWidth(0.4), "\n");
}

void ScriptWriter::AddCell(const Cell& cell) {
  // Strong enough to be told apart, light enough for dark words on it.
  Add("set object rectangle from first ", Number(cell.x - 0.5), ", first ",
      Number(cell.y - 0.5), " to first ", Number(cell.x + 0.5), ", first ",
      Number(cell.y + 0.5), " behind fs transparent solid ",
      Number(0.75 * cell.shade), " border lc rgb '", kGridColour, "' fc rgb '",
      ColourOf(Role::kMeasured), "'\n");
}

void ScriptWriter::AddData(const Panel& panel, const Series& series,
                           const std::string& name) {
  const bool band = !series.lower.empty();
  const auto row = [&](double x, std::size_t i) {
    Add(Number(x), " ", Number(series.y[i]));
    if (band) Add(" ", Number(series.lower[i]), " ", Number(series.upper[i]));
    Add("\n");
  };
  const auto is_shown = [&](std::size_t i) {
    return IsShown(series.x[i], panel.x.log) &&
           IsShown(series.y[i], panel.y.log) &&
           (!band || (IsShown(series.lower[i], panel.y.log) &&
                      IsShown(series.upper[i], panel.y.log)));
  };
  Add(name, " << EOD\n");
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!is_shown(i)) {
      Add("\n");  // an empty line breaks the curve
      continue;
    }
    row(series.x[i], i);
    if (series.steps && i + 1 < series.x.size() &&
        IsShown(series.x[i + 1], panel.x.log)) {
      row(series.x[i + 1], i);
    }
  }
  Add("EOD\n");
}

void ScriptWriter::AddPlot(const Panel& panel) {
  // The first curve draws nothing: it keeps the axes where there is no data.
  Add("plot NaN notitle");
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    if (series.x.empty()) continue;
    const std::string name = absl::StrCat("$series", i);
    if (!series.lower.empty()) {
      Add(", ", name,
          " using 1:3:4 with filledcurves fs transparent solid 0.2 noborder "
          "lc rgb '",
          ColourOf(series.style.colour), "' notitle");
    }
    const bool line = series.style.line != LineStyle::kNone;
    const bool points = series.style.marker != MarkerShape::kNone;
    if (!line && !points) continue;
    Add(", ", name, " using 1:2 with ",
        line && points ? "linespoints "
        : line         ? "lines "
                       : "points ",
        LineOf(series.style),
        points ? absl::StrCat(" ", PointOf(series.style)) : "", " notitle");
  }
  Add("\n");
}

void ScriptWriter::AddPanel(const Panel& panel, const PanelLayout& placed) {
  const Frame& frame = placed.frame;
  const auto margin = [&](std::string_view side, double fraction) {
    Add("set ", side, "margin at screen ", Number(fraction), "\n");
  };
  margin("l", frame.left / layout_.width_pt);
  margin("r", frame.right / layout_.width_pt);
  margin("b", frame.bottom / layout_.height_pt);
  margin("t", frame.top / layout_.height_pt);
  Add("set border 3 back lc rgb '", kFrameColour, "' ", LineWidth(0.6), "\n");
  if (panel.cells.empty()) {
    Add("set grid xtics ytics back lt 1 lc rgb '", kGridColour, "' ",
        LineWidth(0.4), " dt solid\n");
  } else {
    Add("unset grid\n");
  }
  AddAxis("x", panel.x.log, placed.x_range, placed.x_ticks);
  AddAxis("y", panel.y.log, placed.y_range, placed.y_ticks);
  for (const Span& span : panel.spans) AddSpan(placed, span);
  for (const Cell& cell : panel.cells) AddCell(cell);
  for (const ReferenceLine& line : panel.lines) {
    AddReferenceLine(panel, placed, line);
  }
  for (const Marker& marker : panel.markers) {
    if (!IsShown(marker.x, panel.x.log) || !IsShown(marker.y, panel.y.log)) {
      continue;
    }
    Add("set label '' at first ", Number(marker.x), ", first ",
        Number(marker.y), " front point ", LineOf(marker.style), " ",
        PointOf(marker.style), "\n");
  }
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    if (panel.series[i].x.empty()) continue;
    AddData(panel, Downsample(panel.series[i], panel.x.log),
            absl::StrCat("$series", i));
  }
  AddPlot(panel);
  Add("unset arrow\nunset label\nunset object\n");
}

void ScriptWriter::AddTexts() {
  for (const PlacedText& text : layout_.texts) {
    const std::string_view align = text.align == TextAlign::kLeft     ? "left"
                                   : text.align == TextAlign::kCenter ? "center"
                                                                      : "right";
    Add("set label ", QuoteForGnuplot(text.text), " at ",
        Screen(text.x, text.y), " ", align,
        text.upright ? " rotate by 90" : " norotate", " noenhanced font ",
        Font(text.size_pt), " textcolor rgb '", kTextColour, "'\n");
  }
}

void ScriptWriter::AddLegend() {
  const double half_band = 0.35 * figure_.font_size_pt;
  for (const LegendSample& sample : layout_.legend) {
    const double middle = 0.5 * (sample.x_begin + sample.x_end);
    if (sample.band) {
      Add("set object rectangle from ",
          Screen(sample.x_begin, sample.y - half_band), " to ",
          Screen(sample.x_end, sample.y + half_band),
          " back fs transparent solid 0.2 noborder fc rgb '",
          ColourOf(sample.style.colour), "'\n");
    }
    if (sample.style.line != LineStyle::kNone) {
      Add("set arrow from ", Screen(sample.x_begin, sample.y), " to ",
          Screen(sample.x_end, sample.y), " nohead back ", LineOf(sample.style),
          "\n");
    }
    if (sample.style.marker != MarkerShape::kNone) {
      Add("set label '' at ", Screen(middle, sample.y), " front point ",
          LineOf(sample.style), " ", PointOf(sample.style), "\n");
    }
  }
}

}  // namespace

std::string QuoteForGnuplot(std::string_view text) {
  std::string out = "\"";
  for (const char c : CleanText(text)) {
    const auto byte = static_cast<unsigned char>(c);
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (letter || c == ' ' || byte >= 0x80) {
      out += c;
      continue;
    }
    out += '\\';
    for (const int shift : {6, 3, 0}) {
      out += static_cast<char>('0' + ((byte >> shift) & 7));
    }
  }
  return out + "\"";
}

std::string GnuplotScript(const Figure& figure, const Layout& layout,
                          const Terminal& terminal) {
  return ScriptWriter(figure, layout, terminal).Write();
}

}  // namespace mle::report
