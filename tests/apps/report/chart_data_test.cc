#include "apps/report/chart_data.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace mle::report {
namespace {

using Numbers = std::vector<double>;

nlohmann::json Data(const Figure& figure) {
  nlohmann::json data =
      nlohmann::json::parse(ChartData(figure), nullptr, false);
  EXPECT_FALSE(data.is_discarded());
  return data;
}

TEST(ChartDataTest, HoldsWhatThePanelShows) {
  Figure figure{.columns = 2};
  Panel& panel = figure.AddPanel("gain");
  panel.x = {.label = "penalty λ", .log = true};
  panel.y = {.label = "E (1)", .range = Range{1.0, 9.0}};
  panel.series.push_back(MakeSeries(Role::kCorrected, "corrected", {0.1, 0.2},
                                    {3.0, std::nan("")}));
  panel.series.back().lower = {2.0, 2.0};
  panel.series.back().upper = {4.0, 4.0};
  panel.lines.push_back(HorizontalLine(Role::kInitial, "before", 7.0));
  panel.lines.push_back(HorizontalLine(Role::kInitial, "none", INFINITY));
  panel.markers.push_back(MakeMarker(Role::kChosen, "chosen", 0.1, 3.0));
  const nlohmann::json data = Data(figure);
  EXPECT_EQ(data["columns"], 2);
  const nlohmann::json& shown = data["panels"][0];
  EXPECT_EQ(shown["title"], "gain");
  EXPECT_EQ(shown["x"]["log"], true);
  EXPECT_EQ(shown["y"]["name"], "E");
  EXPECT_EQ(shown["y"]["range"], (Numbers{1.0, 9.0}));
  ASSERT_EQ(shown["series"].size(), 2);
  EXPECT_EQ(shown["series"][0]["x"], (Numbers{0.1, 0.2}));
  EXPECT_TRUE(shown["series"][0]["y"][1].is_null());
  EXPECT_EQ(shown["series"][0]["upper"], (Numbers{4.0, 4.0}));
  EXPECT_EQ(shown["series"][0]["colour"], NameOf(Role::kCorrected));
  EXPECT_EQ(shown["series"][1]["label"], "chosen");
  EXPECT_EQ(shown["series"][1]["line"], false);
  ASSERT_EQ(shown["lines"].size(), 1);
  EXPECT_EQ(shown["lines"][0]["value"], 7.0);
}

TEST(ChartDataTest, HoldsStretchesAndNames) {
  Figure figure{.columns = 2};
  for (const char* title : {"a", "b"}) figure.AddPanel(title);
  figure.panels[0].y.label = "E";
  figure.panels[1].x.names = {"first", "\"second\""};
  figure.panels[1].spans.push_back(
      MakeSpan(Role::kWindow, "window", -1.0, 2.5));
  const nlohmann::json shown = Data(figure)["panels"][1];
  EXPECT_EQ(shown["x"]["names"], (nlohmann::json{"first", "\"second\""}));
  EXPECT_EQ(shown["spans"][0]["from"], -1.0);
  EXPECT_EQ(shown["spans"][0]["to"], 2.5);
  EXPECT_EQ(shown["spans"][0]["colour"], "window");
  // The first of a row has the label of all.
  EXPECT_EQ(shown["y"]["label"], "E");
}

TEST(ChartDataTest, TextCannotEndTheScriptItStandsIn) {
  Figure figure;
  const std::string label = "</script><b>\"\\\n&";
  figure.AddPanel(label);
  const std::string text = ChartData(figure);
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("<")));
  EXPECT_EQ(Data(figure)["panels"][0]["title"], "</script><b>\"\\ &");
}

TEST(ChartDataTest, LongSeriesKeepTheirExtremes) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  Numbers x, y;
  for (int i = 0; i < 100000; ++i) {
    x.push_back(i);
    y.push_back(i == 54321 ? 7.0 : i == 77777 ? -7.0 : std::sin(0.01 * i));
  }
  panel.series.push_back(MakeSeries(Role::kMeasured, "signal", x, y));
  const auto shown = Data(figure)["panels"][0]["series"][0]["y"].get<Numbers>();
  EXPECT_LE(shown.size(), 5000U);
  EXPECT_EQ(*std::max_element(shown.begin(), shown.end()), 7.0);
  EXPECT_EQ(*std::min_element(shown.begin(), shown.end()), -7.0);
}

TEST(ChartDataTest, StairsKeepTheirCorners) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.series.push_back(MakeSeries(Role::kSetPoint, "set point",
                                    {0, 1, 2, 3, 4, 5, 6},
                                    {1, 1, 1, 1, 2, 2, 2}));
  panel.series.back().steps = true;
  const nlohmann::json series = Data(figure)["panels"][0]["series"][0];
  EXPECT_EQ(series["x"], (Numbers{0, 3, 4, 6}));
  EXPECT_EQ(series["y"], (Numbers{1, 1, 2, 2}));
}

}  // namespace
}  // namespace mle::report
