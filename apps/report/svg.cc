#include "apps/report/svg.h"

#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "apps/report/font.h"
#include "apps/report/layout.h"
#include "apps/report/svg_panel.h"
#include "apps/report/svg_parts.h"
#include "apps/report/text.h"
#include "mle/base/status.h"

namespace mle::report {
namespace {

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
    path.MoveTo(sample.x_begin, y);
    path.LineTo(sample.x_end, y);
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
