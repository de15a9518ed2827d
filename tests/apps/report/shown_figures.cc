#include "tests/apps/report/shown_figures.h"

#include <cmath>
#include <sstream>

#include "gtest/gtest.h"
#include "tests/apps/report/markup.h"

namespace mle::report {
namespace {

struct ShownAxis {
  Range range;
  bool log = false;

  double At(double part) const {
    if (!log) return range.min + part * (range.max - range.min);
    return range.min * std::pow(range.max / range.min, part);
  }
};

ShownAxis AxisOf(const std::string& text) {
  ShownAxis axis;
  std::string log;
  std::istringstream words(text);
  words >> axis.range.min >> axis.range.max >> log;
  axis.log = log == "log";
  return axis;
}

// Calls `point` with each place behind M, L, H or V.
template <typename Point>
void ForEachPoint(const std::string& path, const Point& point) {
  double x = 0.0;
  double y = 0.0;
  for (std::size_t at = 0; at < path.size(); ++at) {
    const char letter = path[at];
    const std::string_view letters = "MLHV";
    if (letters.find(letter) == std::string_view::npos) continue;
    std::istringstream numbers(path.substr(at + 1, 30));
    if (letter != 'V') numbers >> x;
    if (letter != 'H') numbers >> y;
    point(x, y);
  }
}

std::string Get(const Element& element, const std::string& attribute) {
  const auto found = element.attributes.find(attribute);
  return found == element.attributes.end() ? "" : found->second;
}

}  // namespace

std::vector<ShownFigure> FiguresOf(std::string_view text, bool html) {
  const Markup markup = ParseMarkup(text, html);
  EXPECT_EQ(markup.error, "");
  std::vector<ShownFigure> figures;
  ShownAxis x;
  ShownAxis y;
  double width = 0.0;
  double height = 0.0;
  ShownSeries* series = nullptr;
  bool repeats = false;
  for (const Element& element : markup.elements) {
    const std::string kind = Get(element, "class");
    if (kind.starts_with("scroll ")) repeats = kind.ends_with(" narrow");
    if (repeats) continue;
    if (kind == "drawing") figures.emplace_back();
    if (figures.empty()) continue;
    std::vector<ShownPanel>& panels = figures.back().panels;
    if (element.name == "text") figures.back().texts.push_back(element.text);
    if (element.name == "g" || kind == "axis") series = nullptr;
    if (kind == "panel") {
      x = AxisOf(Get(element, "data-x"));
      y = AxisOf(Get(element, "data-y"));
      panels.push_back({.x = x.range, .y = y.range});
    } else if (kind == "plot") {
      width = std::stod(Get(element, "width"));
      height = std::stod(Get(element, "height"));
    } else if (kind.starts_with("span ")) {
      ++panels.back().spans;
    } else if (kind.starts_with("series ")) {
      series = &panels.back().series.emplace_back();
    } else if (series != nullptr && element.name == "title") {
      series->label = element.text;
    } else if (series != nullptr && element.name == "path" && kind != "band") {
      ForEachPoint(Get(element, "d"), [&](double px, double py) {
        series->x.push_back(x.At(px / width));
        series->y.push_back(y.At(1.0 - py / height));
      });
    }
  }
  return figures;
}

}  // namespace mle::report
