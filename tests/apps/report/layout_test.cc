#include "apps/report/layout.h"

#include <cmath>
#include <string>

#include "apps/report/text.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::report {
namespace {

struct Box {
  double left, right, bottom, top;
};

// DejaVu Sans rises 0.76 of its size above the base line and falls 0.24 below
// it; digits and lower-case letters, which labels consist of, stay well inside.
Box BoxOf(const PlacedText& text) {
  const double width = TextWidth(text.text) * text.size_pt;
  const double begin = text.align == TextAlign::kLeft     ? 0.0
                       : text.align == TextAlign::kCenter ? -0.5 * width
                                                          : -width;
  const double half = 0.5 * text.size_pt;
  if (text.upright) {
    return {text.x - half, text.x + half, text.y + begin,
            text.y + begin + width};
  }
  return {text.x + begin, text.x + begin + width, text.y - half, text.y + half};
}

bool Overlap(const Box& a, const Box& b) {
  return a.left < b.right && b.left < a.right && a.bottom < b.top &&
         b.bottom < a.top;
}

Figure Example(int panels, int columns, double width_cm, double height_cm) {
  Figure figure{.title = "Step responses",
                .width_cm = width_cm,
                .height_cm = height_cm,
                .columns = columns};
  for (int i = 0; i < panels; ++i) {
    Panel& panel = figure.AddPanel("distillate composition ← reflux flow");
    panel.x = {.label = "time (min)", .log = i % 2 == 1};
    panel.y = {.label = "step response (mol %)", .log = i % 3 == 1};
    panel.series.push_back(MakeSeries(Role::kTrue, "true plant",
                                      {1e-6, 1e-2, 400.0},
                                      {-12345.0 - i, 0.01, 19363.0}));
    panel.series.push_back(MakeSeries(Role::kCorrected,
                                      "corrected, λ chosen by cross-validation",
                                      {1e-6}, {2.0}));
    panel.lines.push_back(HorizontalLine(Role::kInitial, "initial model", 5.0));
    panel.markers.push_back(MakeMarker(Role::kBest, "best λ", 1.0, 3.0));
  }
  return figure;
}

class LayoutTest : public ::testing::TestWithParam<Figure> {};

TEST_P(LayoutTest, NoTextIsCutOffOrWrittenOverAnother) {
  const auto layout = MakeLayout(GetParam());
  ASSERT_TRUE(layout.ok()) << layout.status();
  const double slack = 0.01;
  for (std::size_t i = 0; i < layout->texts.size(); ++i) {
    const Box a = BoxOf(layout->texts[i]);
    EXPECT_GE(a.left, -slack) << layout->texts[i].text;
    EXPECT_LE(a.right, layout->width_pt + slack) << layout->texts[i].text;
    EXPECT_GE(a.bottom, -slack) << layout->texts[i].text;
    EXPECT_LE(a.top, layout->height_pt + slack) << layout->texts[i].text;
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(Overlap(a, BoxOf(layout->texts[j])))
          << layout->texts[i].text << " and " << layout->texts[j].text;
    }
    for (const PanelLayout& panel : layout->panels) {
      const Frame& f = panel.frame;
      EXPECT_FALSE(Overlap(a, {f.left, f.right, f.bottom, f.top}))
          << layout->texts[i].text;
    }
  }
}

TEST_P(LayoutTest, FramesAreAlikeAndApart) {
  const auto layout = MakeLayout(GetParam());
  ASSERT_TRUE(layout.ok()) << layout.status();
  const Frame& first = layout->panels[0].frame;
  for (std::size_t i = 1; i < layout->panels.size(); ++i) {
    const Frame& f = layout->panels[i].frame;
    EXPECT_NEAR(f.right - f.left, first.right - first.left, 1e-9);
    EXPECT_NEAR(f.top - f.bottom, first.top - first.bottom, 1e-9);
    for (std::size_t j = 0; j < i; ++j) {
      const Frame& g = layout->panels[j].frame;
      EXPECT_FALSE(Overlap({f.left, f.right, f.bottom, f.top},
                           {g.left, g.right, g.bottom, g.top}));
    }
  }
}

TEST_P(LayoutTest, TheLegendNamesEachThingOnce) {
  const auto layout = MakeLayout(GetParam());
  ASSERT_TRUE(layout.ok()) << layout.status();
  EXPECT_EQ(layout->legend.size(), 4u);
  for (const LegendSample& sample : layout->legend) {
    EXPECT_LT(sample.x_begin, sample.x_end);
    EXPECT_GE(sample.x_begin, 0.0);
    EXPECT_LE(sample.x_end, layout->width_pt);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Sizes, LayoutTest,
    ::testing::Values(Example(1, 1, 8.5, 6.0), Example(2, 2, 17.0, 6.0),
                      Example(4, 2, 8.5, 12.0), Example(4, 2, 17.0, 11.0),
                      Example(5, 3, 17.0, 11.0), Example(9, 3, 30.0, 30.0)),
    [](const auto& test) {
      return "panels" + std::to_string(test.param.panels.size()) + "at" +
             std::to_string(test.index);
    });

TEST(MakeLayout, LongNamesAreShortenedToTheRoomTheyHave) {
  Figure figure;
  Panel& panel = figure.AddPanel(std::string(5000, 'W'));
  panel.x.label = panel.y.label = std::string(5000, 'm');
  panel.series.push_back(
      MakeSeries(Role::kTrue, std::string(5000, 'x'), {0.0, 1.0}, {0.0, 1.0}));
  const auto layout = MakeLayout(figure);
  ASSERT_TRUE(layout.ok());
  int shortened = 0;
  for (const PlacedText& text : layout->texts) {
    const Box box = BoxOf(text);
    EXPECT_GE(box.left, 0.0);
    EXPECT_LE(box.right, layout->width_pt);
    EXPECT_GE(box.bottom, 0.0);
    EXPECT_LE(box.top, layout->height_pt);
    if (text.text.ends_with("…")) ++shortened;
  }
  EXPECT_EQ(shortened, 4);
}

// A map of three by two with long words and names.
Figure Map() {
  Figure figure{.width_cm = 12.0, .height_cm = 6.0, .legend = false};
  Panel& panel = figure.AddPanel("");
  panel.x.label = "input";
  panel.y.label = "output";
  panel.x.names = {"reflux", std::string(200, 'x'), "steam"};
  panel.y.names = {"overhead composition of the column", "bottoms"};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      panel.cells.push_back({1.0 * j,
                             1.0 * i,
                             0.5,
                             {"gain × 0.644", std::string(100, 'w'), "p"}});
    }
  }
  return figure;
}

TEST(MakeLayout, WordsStayInTheirCell) {
  const absl::StatusOr<Layout> layout = MakeLayout(Map());
  ASSERT_TRUE(layout.ok()) << layout.status();
  const Frame& frame = layout->panels[0].frame;
  const double width = (frame.right - frame.left) / 3.0;
  const double height = (frame.top - frame.bottom) / 2.0;
  int words = 0;
  for (std::size_t a = 0; a < layout->texts.size(); ++a) {
    const Box box = BoxOf(layout->texts[a]);
    EXPECT_GE(box.left, 0.0);
    EXPECT_LE(box.right, layout->width_pt);
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_FALSE(Overlap(box, BoxOf(layout->texts[b])))
          << layout->texts[a].text << " and " << layout->texts[b].text;
    }
    if (box.left < frame.left || box.bottom < frame.bottom) continue;
    ++words;
    const auto cell = [&](double place, double start, double size) {
      return std::floor((place - start) / size);
    };
    EXPECT_EQ(cell(box.left, frame.left, width),
              cell(box.right, frame.left, width));
    EXPECT_EQ(cell(box.bottom, frame.bottom, height),
              cell(box.top, frame.bottom, height));
  }
  EXPECT_EQ(words, 18);
}

TEST(MakeLayout, WhatIsNotDrawnIsNotInTheLegend) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.y.log = true;
  panel.series.push_back(MakeSeries(Role::kTrue, "negative", {1.0}, {-1.0}));
  panel.lines.push_back(HorizontalLine(Role::kInitial, "zero", 0.0));
  panel.markers.push_back(MakeMarker(Role::kBest, "none", 1.0, NAN));
  const auto layout = MakeLayout(figure);
  ASSERT_TRUE(layout.ok());
  EXPECT_TRUE(layout->legend.empty());
}

TEST(MakeLayout, SaysThatAPanelIsEmpty) {
  Figure figure;
  figure.AddPanel("");
  const auto layout = MakeLayout(figure);
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->texts.back().text, "no data");
}

TEST(MakeLayout, RefusesMorePanelsThanFit) {
  const auto layout = MakeLayout(Example(30, 1, 8.5, 6.0));
  EXPECT_EQ(layout.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(layout.status().message()),
              ::testing::HasSubstr("too small for 30 × 1 panels"));
}

TEST(TextWidth, OfDejaVuSans) {
  // Advances from the font's own table: 1401 + 1303 of 2048 units.
  EXPECT_DOUBLE_EQ(TextWidth("A0"), (1401.0 + 1303.0) / 2048.0);
  EXPECT_EQ(Ellipsized("short", 100.0), "short");
  EXPECT_LE(TextWidth(Ellipsized(std::string(50, 'x'), 10.0)), 10.0);
}

}  // namespace
}  // namespace mle::report
