#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "apps/report/layout.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::report {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> Labels(const std::vector<Tick>& ticks) {
  std::vector<std::string> labels;
  for (const Tick& tick : ticks) {
    if (!tick.label.empty()) labels.push_back(tick.label);
  }
  return labels;
}

TEST(Ticks, LinearExamples) {
  EXPECT_THAT(Labels(Ticks({0.0, 100.0}, false, 5)),
              ElementsAre("0", "20", "40", "60", "80", "100"));
  EXPECT_THAT(Labels(Ticks({-0.3, 0.25}, false, 3)),
              ElementsAre("−0.2", "0.0", "0.2"));
  EXPECT_THAT(Labels(Ticks({0.0, 3e6}, false, 3)),
              ElementsAre("0", "1×10⁶", "2×10⁶", "3×10⁶"));
  EXPECT_THAT(Labels(Ticks({0.0, 3e-6}, false, 3)),
              ElementsAre("0", "1×10⁻⁶", "2×10⁻⁶", "3×10⁻⁶"));
}

// Differences that have no inverse are drawn as none.
TEST(Ticks, EndWhereValuesAreNextToNothing) {
  for (const double value : {5e-324, 1e-310, 1e-201}) {
    Panel panel;
    panel.series.push_back({});
    panel.series.back().x = {0.0, 1.0, 2.0};
    panel.series.back().y = {0.0, value, 0.0};
    const Range range = YRange(panel);
    EXPECT_LE(range.min, -0.5);
    EXPECT_GE(range.max, 0.5);
    EXPECT_LT(Ticks(range, false, 5).size(), 12u);
  }
}

TEST(Ticks, LogarithmicExamples) {
  EXPECT_THAT(Labels(Ticks({1e-6, 1e-2}, true, 6)),
              ElementsAre("10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"));
  EXPECT_THAT(Labels(Ticks({1e-9, 1e3}, true, 5)),
              ElementsAre("10⁻⁹", "10⁻⁶", "10⁻³", "1", "10³"));
  EXPECT_THAT(Labels(Ticks({0.4, 6.0}, true, 5)),
              ElementsAre("0.5", "1", "2", "5"));
  EXPECT_THAT(Labels(Ticks({200.0, 400.0}, true, 4)),
              ElementsAre("200", "250", "300", "350", "400"));
}

TEST(Ticks, LieInTheRangeInOrderWithDistinctLabels) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-8.0, 8.0);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int trial = 0; trial < 2000; ++trial) {
    const bool log = trial % 2 == 0;
    const double scale = std::pow(10.0, exponent(random));
    Range range{scale * unit(random), scale * unit(random)};
    if (log) range = {scale, scale * std::pow(10.0, exponent(random))};
    if (range.min > range.max) std::swap(range.min, range.max);
    const int wanted = 2 + trial % 8;
    const std::vector<Tick> ticks = Ticks(range, log, wanted);
    const double slack = 1e-6 * (range.max - range.min);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      ASSERT_GE(ticks[i].value, range.min - slack);
      ASSERT_LE(ticks[i].value, range.max + slack);
      if (i > 0) {
        ASSERT_GT(ticks[i].value, ticks[i - 1].value);
      }
    }
    const auto labels = Labels(ticks);
    EXPECT_EQ(std::set<std::string>(labels.begin(), labels.end()).size(),
              labels.size())
        << ::testing::PrintToString(labels);
    EXPECT_GE(labels.size(), 1u) << range.min << " " << range.max << " " << log;
    // 1-2-5 steps are at most 2.5 times too fine; the ends may add one, and a
    // short logarithmic axis has three labels a power of ten.
    EXPECT_LE(labels.size(), 2u * wanted + 6u);
  }
}

Panel PanelOf(std::vector<double> x, std::vector<double> y) {
  Panel panel;
  panel.series.push_back(
      MakeSeries(Role::kCorrected, "", std::move(x), std::move(y)));
  return panel;
}

TEST(Ranges, CoverWhatIsShownAndNoMore) {
  Panel panel =
      PanelOf({0.0, 1.0, 2.0, 10.0, kNaN}, {1.0, kNaN, 3.0, kInfinity, 100.0});
  EXPECT_EQ(XRange(panel).min, 0.0);
  EXPECT_EQ(XRange(panel).max, 2.0);
  // A twentieth of 3 − 1 to spare at each end.
  EXPECT_DOUBLE_EQ(YRange(panel).min, 0.9);
  EXPECT_DOUBLE_EQ(YRange(panel).max, 3.1);
  panel.lines.push_back(HorizontalLine(Role::kReference, "", -17.0));
  panel.markers.push_back(MakeMarker(Role::kBest, "", 5.0, 4.0));
  EXPECT_EQ(XRange(panel).max, 5.0);
  EXPECT_DOUBLE_EQ(YRange(panel).min, -17.0 - 0.05 * 21.0);
}

TEST(Ranges, ReachATickThatIsNear) {
  // 0.2 is a thousandth of the axis, 3.2 more than a fiftieth.
  EXPECT_DOUBLE_EQ(XRange(PanelOf({0.0, 199.8}, {0.0, 1.0})).max, 200.0);
  EXPECT_DOUBLE_EQ(XRange(PanelOf({0.0, 103.2}, {0.0, 1.0})).max, 103.2);
}

TEST(Ranges, OnlyPositiveValuesCountOnALogarithmicAxis) {
  Panel panel = PanelOf({0.0, 1e-6, 1e-2}, {5.0, 10.0, 1000.0});
  panel.x.log = true;
  panel.y.log = true;
  EXPECT_DOUBLE_EQ(XRange(panel).min, 1e-6);
  EXPECT_DOUBLE_EQ(XRange(panel).max, 1e-2);
  EXPECT_NEAR(YRange(panel).min, std::pow(10.0, 0.9), 1e-12);
  EXPECT_NEAR(YRange(panel).max, std::pow(10.0, 3.1), 1e-9);
}

TEST(Ranges, AreProperWithoutOrWithConstantData) {
  for (const bool log : {false, true}) {
    for (const std::vector<double>& y : {std::vector<double>{},
                                         {kNaN},
                                         {-3.0},
                                         {0.0},
                                         {4.0},
                                         {1e199, -1e199}}) {
      Panel panel = PanelOf(y, y);
      panel.x.log = panel.y.log = log;
      for (const Range& range : {XRange(panel), YRange(panel)}) {
        EXPECT_LT(range.min, range.max);
        EXPECT_TRUE(std::isfinite(range.max - range.min));
        if (log) {
          EXPECT_GT(range.min, 0.0);
        }
      }
    }
  }
}

TEST(Ranges, HoldStretchesAndNamedPlaces) {
  Panel panel;
  panel.spans.push_back(MakeSpan(Role::kWindow, "", -3.0, 5.0));
  EXPECT_LE(XRange(panel).min, -3.0);
  EXPECT_GE(XRange(panel).max, 5.0);
  panel.x.names = {"a", "b", "c"};
  EXPECT_EQ(XRange(panel).min, -0.5);
  EXPECT_EQ(XRange(panel).max, 2.5);
  const std::vector<Tick> ticks = NamedTicks(panel.x.names);
  ASSERT_EQ(ticks.size(), 3u);
  EXPECT_EQ(ticks[2].value, 2.0);
  EXPECT_EQ(ticks[2].label, "c");
}

TEST(Ranges, LinesAcrossALogarithmicAxisAreNotItsEnds) {
  Panel panel;
  panel.x.log = true;
  panel.lines.push_back(VerticalLine(Role::kInitial, "", 1.0));
  panel.lines.push_back(VerticalLine(Role::kTrue, "", 100.0));
  EXPECT_LT(XRange(panel).min, 1.0);
  EXPECT_GT(XRange(panel).max, 100.0);
}

TEST(Fraction, RunsFromZeroToOne) {
  EXPECT_DOUBLE_EQ(Fraction(5.0, {0.0, 20.0}, false), 0.25);
  EXPECT_NEAR(Fraction(1e-4, {1e-6, 1e-2}, true), 0.5, 1e-15);
}

}  // namespace
}  // namespace mle::report
