#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/report/svg.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

// From the middle: "m" to where the shape starts, then its outline.
std::string Outline(MarkerShape shape, double radius) {
  const std::string r = Coordinate(radius);
  const std::string d = Coordinate(2.0 * radius);
  switch (shape) {
    case MarkerShape::kNone:
      return "";
    case MarkerShape::kCross:
      return absl::StrCat("m-", r, " -", r, "l", d, " ", d, "m-", d, " 0l", d,
                          " -", d);
    case MarkerShape::kPlus:
      return absl::StrCat("m-", r, " 0h", d, "m-", r, " -", r, "v", d);
    case MarkerShape::kCircle:
    case MarkerShape::kDisc:
      return absl::StrCat("m-", r, " 0a", r, " ", r, " 0 1 0 ", d, " 0a", r,
                          " ", r, " 0 1 0 -", d, " 0z");
  }
  return "";
}

// Dashes in points, on a line 1 pt wide or less; wider lines have longer ones.
std::string Dashes(const Style& style) {
  std::vector<double> pattern;
  if (style.line == LineStyle::kDashed) pattern = {4.5, 2.5};
  if (style.line == LineStyle::kDotted) pattern = {1.2, 2.0};
  if (style.line == LineStyle::kDashDotted) pattern = {4.5, 2.0, 1.2, 2.0};
  if (pattern.empty()) return "";
  std::string out;
  for (const double length : pattern) {
    absl::StrAppend(&out, out.empty() ? "" : " ",
                    Coordinate(length * std::max(style.width_pt, 1.0)));
  }
  return absl::StrCat(" stroke-dasharray=\"", out, "\"");
}

}  // namespace

std::string Coordinate(double value) {
  constexpr double kFurthest = 1e5;
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                 std::clamp(value, -kFurthest, kFurthest),
                                 std::chars_format::fixed, 2);
  std::string text(buffer.data(), end.ptr);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

void SvgPath::MoveTo(double x, double y) {
  x_ = Coordinate(x);
  y_ = Coordinate(y);
  absl::StrAppend(&d_, "M", x_, " ", y_);
}

void SvgPath::LineTo(double x, double y) {
  const std::string to_x = Coordinate(x);
  const std::string to_y = Coordinate(y);
  if (to_y == y_) {
    absl::StrAppend(&d_, "H", to_x);
  } else if (to_x == x_) {
    absl::StrAppend(&d_, "V", to_y);
  } else {
    absl::StrAppend(&d_, "L", to_x, " ", to_y);
  }
  x_ = to_x;
  y_ = to_y;
}

void SvgPath::AddShape(MarkerShape shape, double x, double y, double size) {
  MoveTo(x, y);
  d_ += Outline(shape, 0.5 * size);
}

std::string Paint(const SvgColour& colour) {
  return absl::StrCat("class=\"", colour.name, "\" color=\"", colour.light,
                      "\"");
}

std::string Paint(Role role, std::string_view more_classes) {
  return absl::StrCat("class=\"", std::string(more_classes), "role-",
                      NameOf(role), "\" color=\"", ColourOf(role), "\"");
}

std::string Attribute(std::string_view name, double value) {
  return absl::StrCat(" ", std::string(name), "=\"", Coordinate(value), "\"");
}

std::string Stroked(const SvgPath& path, double width, std::string_view more) {
  if (path.empty()) return "";
  return absl::StrCat(
      "<path d=\"", path.d(), "\" fill=\"none\" ", "stroke=\"currentColor\"",
      Attribute("stroke-width", width), std::string(more), "/>\n");
}

std::string Line(const SvgPath& path, const Style& style) {
  return Stroked(path, style.width_pt,
                 " stroke-linejoin=\"round\"" + Dashes(style));
}

std::string Shapes(const SvgPath& path, const Style& style) {
  if (path.empty()) return "";
  const bool filled = style.marker == MarkerShape::kDisc;
  return absl::StrCat(
      "<path d=\"", path.d(), "\" fill=\"", filled ? "currentColor" : "none",
      "\" stroke=\"currentColor\"",
      Attribute("stroke-width", std::clamp(style.width_pt, 0.75, 1.75)),
      "/>\n");
}

std::string Rectangle(double x, double y, double width, double height,
                      std::string_view more) {
  return absl::StrCat("<rect", Attribute("x", x), Attribute("y", y),
                      Attribute("width", width), Attribute("height", height),
                      " fill=\"currentColor\"", std::string(more), "/>\n");
}

std::string Title(std::string_view label) {
  if (label.empty()) return "";
  return absl::StrCat("<title>", EscapeHtml(label), "</title>\n");
}

}  // namespace mle::report
