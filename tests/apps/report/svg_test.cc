#include "apps/report/svg.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "apps/report/layout.h"
#include "apps/report/text.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "tests/apps/report/markup.h"
#include "tests/apps/report/shown_figures.h"

namespace mle::report {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::Not;

std::string File(const Figure& figure) {
  const auto svg = SvgFile(figure, "A title", "What is seen");
  EXPECT_TRUE(svg.ok()) << svg.status();
  return svg.value_or("");
}

ShownFigure Shown(const Figure& figure) {
  const std::vector<ShownFigure> figures = FiguresOf(File(figure), false);
  EXPECT_EQ(figures.size(), 1u);
  return figures.at(0);
}

Figure WithSeries(const Series& series, bool log = false) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.x.log = panel.y.log = log;
  panel.series.push_back(series);
  return figure;
}

Figure ExampleFigure() {
  Figure figure{.width_cm = 17.0, .height_cm = 6.0, .columns = 2};
  for (const char* name : {"gain", "delay"}) {
    Panel& panel = figure.AddPanel(name);
    panel.x = {.label = "λ", .log = true};
    panel.y = {.label = "E", .log = true};
    Series series =
        MakeSeries(Role::kCorrected, "corrected", {1e-6, 1e-5, 1e-4, 0.0, 1e-2},
                   {100.0, 8.0, 9.0, kNaN, 19363.0});
    series.lower = {90.0, 7.0, 8.0, 1.0, 1e4};
    series.upper = {110.0, 9.0, 10.0, 2.0, 2e4};
    panel.series.push_back(series);
    panel.lines.push_back(HorizontalLine(Role::kInitial, "initial", 19363.0));
    panel.markers.push_back(MakeMarker(Role::kChosen, "chosen λ", 1e-4, 9.0));
    panel.markers.push_back(MakeMarker(Role::kBest, "best λ", 1e-5, 8.0));
  }
  return figure;
}

TEST(SvgPath, CoordinatesAreShort) {
  EXPECT_EQ(Coordinate(12.346), "12.35");
  EXPECT_EQ(Coordinate(-12.0), "-12");
  EXPECT_EQ(Coordinate(100.0), "100");
  EXPECT_EQ(Coordinate(-0.001), "0");
  EXPECT_EQ(Coordinate(1e300), "100000");
  SvgPath path;
  path.MoveTo(1.0, 2.0);
  path.LineTo(3.0, 2.001);
  path.LineTo(3.0, 5.0);
  path.LineTo(4.5, 6.0);
  EXPECT_EQ(path.d(), "M1 2H3V5L4.5 6");
}

TEST(SvgTest, IsWellFormedAndHasEveryLabel) {
  const Markup markup = ParseMarkup(File(ExampleFigure()));
  ASSERT_EQ(markup.error, "");
  const auto& root = markup.elements[0].attributes;
  EXPECT_EQ(markup.elements[0].name, "svg");
  // 17 cm × 6 cm.
  EXPECT_EQ(root.at("width"), "481.89pt");
  EXPECT_EQ(root.at("height"), "170.08pt");
  EXPECT_EQ(root.at("role"), "img");
  EXPECT_THAT(markup.Texts("title"), Contains("A title"));
  EXPECT_THAT(markup.Texts("desc"), ElementsAre("What is seen"));
  for (const char* label : {"gain", "delay", "λ", "E", "corrected", "initial",
                            "chosen λ", "best λ", "10⁻⁶", "10³"}) {
    EXPECT_THAT(markup.Texts("text"), Contains(label));
  }
}

TEST(SvgTest, SameFigureSameBytes) {
  EXPECT_EQ(File(ExampleFigure()), File(ExampleFigure()));
  EXPECT_EQ(*SvgElement(ExampleFigure(), "x"),
            *SvgElement(ExampleFigure(), "x"));
}

TEST(SvgTest, NothingInItIsSharedOrActive) {
  for (const std::string& svg :
       {File(ExampleFigure()), *SvgElement(ExampleFigure(), "What is seen")}) {
    const Markup markup = ParseMarkup(svg);
    EXPECT_THAT(markup.Values("id"), IsEmpty());
    EXPECT_THAT(markup.Values("href"), IsEmpty());
    EXPECT_THAT(svg, Not(HasSubstr("url(")));
    for (const char* name : {"script", "image", "a", "foreignObject"}) {
      EXPECT_EQ(markup.Count(name), 0) << name;
    }
  }
}

TEST(SvgTest, AnElementOfAPageSaysWhatIsSeenAndFollowsItsWidth) {
  const Markup markup =
      ParseMarkup(*SvgElement(ExampleFigure(), "a \"b\" <c>"));
  ASSERT_EQ(markup.error, "");
  const auto& root = markup.elements[0].attributes;
  EXPECT_EQ(root.at("aria-label"), "a \"b\" <c>");
  EXPECT_FALSE(root.contains("width"));
  // 17 cm are 642.5 px.
  EXPECT_EQ(root.at("style"), "max-width:900px;min-width:546px");
  EXPECT_EQ(markup.Count("style"), 0);
}

TEST(SvgTest, LabelsAreTakenLiterally) {
  for (const std::string& label : std::vector<std::string>{
           "'", "\"", "a_1^2 {/Symbol a} %d", "<script>alert(1)</script>",
           "]]> & &amp; </text></svg>", "--> <!-- <?x ?>", "😀 温度 é λ",
           "\xff\xfe broken", "\x1b[31m red \x01\x0b\x7f",
           "\u202e right to left \ufffe \ufdd0"}) {
    Figure figure{.width_cm = 40.0};
    Panel& panel = figure.AddPanel(label);
    panel.series.push_back(
        MakeSeries(Role::kTrue, label, {0.0, 1.0}, {0.0, 1.0}));
    const auto svg = SvgFile(figure, label, label);
    ASSERT_TRUE(svg.ok());
    const Markup markup = ParseMarkup(*svg);
    EXPECT_EQ(markup.error, "") << label;
    EXPECT_EQ(markup.Count("script"), 0) << label;
    // In the legend and above the panel; of the file and of the curve.
    EXPECT_THAT(markup.Texts("text"), Contains(CleanText(label)).Times(2));
    EXPECT_THAT(markup.Texts("title"), Contains(CleanText(label)).Times(2));
    EXPECT_EQ(svg->find("]]>"), std::string::npos);
  }
}

TEST(SvgTest, EveryFinitePointLiesInTheFrame) {
  std::vector<double> x, y;
  for (int i = 0; i < 300; ++i) {
    x.push_back(0.37 * i - 11.0);
    y.push_back(1e3 * std::sin(0.1 * i) * std::exp(-0.01 * i));
  }
  y[17] = kNaN;
  y[40] = std::numeric_limits<double>::infinity();
  const ShownPanel panel =
      Shown(WithSeries(MakeSeries(Role::kCorrected, "c", x, y))).panels.at(0);
  ASSERT_EQ(panel.series.size(), 1u);
  const ShownSeries& series = panel.series[0];
  ASSERT_EQ(series.x.size(), 298u);
  EXPECT_THAT(series.x, Each(AllOf(Ge(panel.x.min), Le(panel.x.max))));
  EXPECT_THAT(series.y, Each(AllOf(Ge(panel.y.min), Le(panel.y.max))));
  std::size_t at = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(y[i])) continue;
    EXPECT_NEAR(series.x[at], x[i], 1e-4 * (panel.x.max - panel.x.min));
    EXPECT_NEAR(series.y[at], y[i], 1e-4 * (panel.y.max - panel.y.min));
    ++at;
  }
}

TEST(SvgTest, LogarithmicAxesPlaceByTheLogarithm) {
  const ShownPanel panel =
      Shown(WithSeries(MakeSeries(Role::kTrue, "", {1e-6, 1e-3, 1.0},
                                  {0.5, 50.0, -1.0}),
                       true))
          .panels.at(0);
  ASSERT_EQ(panel.series[0].x.size(), 2u);
  EXPECT_NEAR(panel.series[0].x[1] / 1e-3, 1.0, 1e-3);
  EXPECT_NEAR(panel.series[0].y[1] / 50.0, 1.0, 1e-3);
}

int CountOf(const std::string& text, const std::string& what) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos;
       ++at) {
    ++count;
  }
  return count;
}

std::string PathAfter(const std::string& svg, const std::string& what) {
  const std::size_t at = svg.find("<path d=\"", svg.find(what)) + 9;
  return svg.substr(at, svg.find('"', at) - at);
}

TEST(SvgTest, PointsThatCannotBeShownBreakTheLine) {
  const std::string svg = File(WithSeries(MakeSeries(
      Role::kTrue, "t", {0, 1, 2, 3, 4, 5, 6}, {1, 2, kNaN, 4, 5, kNaN, 7})));
  const std::string path = PathAfter(svg, "class=\"series");
  EXPECT_EQ(CountOf(path, "M"), 2);
  // The last point stands alone: a dot.
  EXPECT_EQ(CountOf(svg, "stroke-linecap=\"round\""), 1);
}

TEST(SvgTest, StepsHoldEachValueUntilTheNext) {
  Series series = MakeSeries(Role::kSetPoint, "", {0, 1, 2}, {5, 6, 7});
  series.steps = true;
  const ShownSeries shown = Shown(WithSeries(series)).panels[0].series.at(0);
  const auto near = [](double value) { return DoubleNear(value, 1e-3); };
  EXPECT_THAT(shown.x,
              ElementsAre(near(0), near(1), near(1), near(2), near(2)));
  EXPECT_THAT(shown.y,
              ElementsAre(near(5), near(5), near(6), near(6), near(7)));
}

TEST(SvgTest, LaterSeriesAndMarkersLieOnTop) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.markers.push_back(MakeMarker(Role::kBest, "marker", 0.5, 0.5));
  Series wide = MakeSeries(Role::kTrue, "wide", {0, 1}, {0, 1});
  wide.lower = {-1, 0};
  wide.upper = {1, 2};
  panel.series.push_back(wide);
  panel.series.push_back(MakeSeries(Role::kCorrected, "thin", {0, 1}, {0, 1}));
  panel.lines.push_back(HorizontalLine(Role::kReference, "across", 0.5));
  panel.spans.push_back(MakeSpan(Role::kWindow, "span", 0.0, 9.0));
  const std::string svg = File(figure);
  std::size_t last = 0;
  for (const char* part : {"<title>span", "<title>across", "<title>wide",
                           "class=\"band\"", "<title>thin", "<title>marker"}) {
    const std::size_t at = svg.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    EXPECT_LT(last, at) << part;
    last = at;
  }
  // The wide line shows on both sides of the thin one.
  EXPECT_THAT(svg, HasSubstr("stroke-width=\"3\""));
  EXPECT_THAT(svg, HasSubstr("stroke-width=\"1.25\""));
}

TEST(SvgTest, WhatLiesOutsideTheRangeIsLeftOut) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.y.range = Range{0.0, 1.0};
  panel.lines.push_back(HorizontalLine(Role::kInitial, "line", 0.5));
  panel.markers.push_back(MakeMarker(Role::kBest, "marker", 0.5, 0.5));
  EXPECT_THAT(File(figure),
              AllOf(HasSubstr("<title>line"), HasSubstr("<title>marker")));
  panel.lines[0].value = 2.0;
  panel.markers[0].y = 2.0;
  EXPECT_THAT(File(figure), AllOf(Not(HasSubstr("<title>line")),
                                  Not(HasSubstr("<title>marker"))));
}

TEST(SvgTest, AStretchFromZeroBeginsAtTheEndOfALogarithmicAxis) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.x = {.log = true, .range = Range{1.0, 100.0}};
  panel.spans.push_back(MakeSpan(Role::kWindow, "span", 0.0, 10.0));
  const std::string svg = File(figure);
  const std::size_t at = svg.find("<rect", svg.find("<title>span"));
  EXPECT_EQ(svg.substr(at, 11), "<rect x=\"0\"");
  panel.spans[0].to = 0.5;
  EXPECT_THAT(File(figure), Not(HasSubstr("<title>span")));
}

TEST(SvgTest, LegendHasEachLabelOnce) {
  const ShownFigure shown = Shown(ExampleFigure());
  for (const char* label : {"corrected", "initial", "chosen λ", "best λ"}) {
    EXPECT_THAT(shown.texts, Contains(label).Times(1));
  }
  EXPECT_EQ(CountOf(File(ExampleFigure()), "class=\"sample "), 4);
  Figure without = ExampleFigure();
  without.legend = false;
  EXPECT_EQ(CountOf(File(without), "class=\"sample "), 0);
}

TEST(SvgTest, LongSeriesAreThinnedAndKeepTheirExtremes) {
  std::vector<double> x, y;
  for (int i = 0; i < 200'000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(1e-3 * i));
  }
  y[123'456] = 40.0;
  const ShownSeries series =
      Shown(WithSeries(MakeSeries(Role::kMeasured, "m", x, y)))
          .panels[0]
          .series.at(0);
  EXPECT_LE(series.x.size(), 4100u);
  EXPECT_THAT(series.y, Contains(DoubleNear(40.0, 0.01)));
}

TEST(SvgTest, MarkersOfASeriesAreShapesAtItsPoints) {
  for (const MarkerShape shape : {MarkerShape::kCross, MarkerShape::kPlus,
                                  MarkerShape::kCircle, MarkerShape::kDisc}) {
    Series series = MakeSeries(Role::kUnused, "bad", {0, 1, 2}, {5, kNaN, 7});
    series.style.marker = shape;
    const ShownSeries shown = Shown(WithSeries(series)).panels[0].series.at(0);
    EXPECT_THAT(shown.x, ElementsAre(DoubleNear(0, 1e-3), DoubleNear(2, 1e-3)));
    EXPECT_THAT(shown.y, ElementsAre(DoubleNear(5, 1e-3), DoubleNear(7, 1e-3)));
  }
}

TEST(SvgTest, DrawsWhatHasNoDataAndWhatIsExtreme) {
  Figure figure{.columns = 3};
  figure.AddPanel("nothing");
  figure.AddPanel("NaN").series.push_back(
      MakeSeries(Role::kTrue, "t", {1.0, 2.0}, {kNaN, kNaN}));
  figure.AddPanel("one").series.push_back(
      MakeSeries(Role::kTrue, "t", {1.0}, {1.0}));
  for (const bool log : {false, true}) {
    Panel& panel = figure.AddPanel("extremes");
    panel.x.log = panel.y.log = log;
    panel.series.push_back(MakeSeries(Role::kTrue, "t", {1e-150, 1.0, 1e150},
                                      {-1e199, 1e-199, 1e199}));
  }
  const std::string svg = File(figure);
  EXPECT_EQ(ParseMarkup(svg).error, "");
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(SvgTest, RefusesBadFigures) {
  EXPECT_EQ(SvgFile(Figure(), "", "").status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(SvgElement(Figure(), "").status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace mle::report
