#include "apps/report/figure.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::report {
namespace {

using ::testing::HasSubstr;

Figure Good() {
  Figure figure;
  Panel& panel = figure.AddPanel("gain");
  panel.series.push_back(
      MakeSeries(Role::kTrue, "true", {0.0, 1.0}, {1.0, 2.0}));
  return figure;
}

TEST(Figure, ValidatesWhatItShows) {
  EXPECT_TRUE(Good().Validate().ok());

  Figure figure = Good();
  figure.panels[0].series[0].y.pop_back();
  EXPECT_THAT(std::string(figure.Validate().message()),
              HasSubstr("panel 1 \"gain\", series 1 \"true\": x has 2 points "
                        "and y 1"));
  figure = Good();
  figure.panels[0].series[0].lower = {1.0, 2.0};
  EXPECT_THAT(std::string(figure.Validate().message()), HasSubstr("the band"));
  figure = Good();
  figure.panels[0].series[0].max_points = 5;
  EXPECT_THAT(std::string(figure.Validate().message()),
              HasSubstr("max_points is 5"));
  figure = Good();
  figure.panels[0].y = {.log = true, .range = Range{0.0, 1.0}};
  EXPECT_THAT(std::string(figure.Validate().message()),
              HasSubstr("y axis: the range is 0 … 1"));
  figure = Good();
  figure.panels[0].x.range = Range{1.0, 1.0};
  EXPECT_FALSE(figure.Validate().ok());
  figure = Good();
  figure.panels[0].markers.push_back(MakeMarker(Role::kBest, "b", 0.0, 0.0));
  figure.panels[0].markers[0].style.marker_size_pt = -1.0;
  EXPECT_THAT(std::string(figure.Validate().message()),
              HasSubstr("marker \"b\""));
}

TEST(Figure, ValidatesItsSize) {
  Figure figure = Good();
  figure.width_cm = kNaN;
  EXPECT_FALSE(figure.Validate().ok());
  figure = Good();
  figure.height_cm = 1.0;
  EXPECT_FALSE(figure.Validate().ok());
  figure = Good();
  figure.font_size_pt = 100.0;
  EXPECT_FALSE(figure.Validate().ok());
  figure = Good();
  figure.columns = 0;
  EXPECT_FALSE(figure.Validate().ok());
  EXPECT_FALSE(Figure().Validate().ok());  // no panel
}

TEST(Roles, OfTheSameFigureDifferInMoreThanColour) {
  const auto look = [](Role role) {
    const Style style = StyleOf(role);
    return std::tuple(style.line, style.width_pt, style.marker);
  };
  std::set<std::tuple<LineStyle, double, MarkerShape>> looks;
  std::set<std::string> colours;
  const std::vector<Role> shown = {Role::kInitial, Role::kTrue,
                                   Role::kCorrected, Role::kUnregularised};
  for (const Role role : shown) {
    looks.insert(look(role));
    colours.insert(ColourOf(role));
  }
  EXPECT_EQ(looks.size(), shown.size());
  EXPECT_EQ(colours.size(), shown.size());
  EXPECT_NE(StyleOf(Role::kChosen).marker, StyleOf(Role::kBest).marker);
}

TEST(Roles, HaveAColourOnEitherGroundAndANameOfTheirOwn) {
  const auto luminance = [](const std::string& colour) {
    double sum = 0.0;
    const double weights[] = {0.2126, 0.7152, 0.0722};
    for (int c = 0; c < 3; ++c) {
      const double part = std::stoi(colour.substr(1 + 2 * c, 2), nullptr, 16);
      const double v = part / 255.0;
      sum += weights[c] *
             (v <= 0.03928 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return sum;
  };
  std::set<std::string> names;
  for (const Role role : AllRoles()) {
    names.insert(NameOf(role));
    // 3 : 1 is what graphics need (WCAG 2.1, 1.4.11); orange and sky blue are
    // wide or of samples, and have less on white.
    EXPECT_LT(luminance(ColourOf(role)), 0.45) << NameOf(role);
    EXPECT_GT(luminance(DarkColourOf(role)) + 0.05,
              3.0 * (luminance("#1a1f24") + 0.05))
        << NameOf(role);
  }
  EXPECT_EQ(names.size(), AllRoles().size());
}

TEST(Validate, NamesWhatIsWrongWithAMap) {
  Figure figure = Good();
  figure.panels[0].spans.push_back(MakeSpan(Role::kWindow, "late", 2.0, 1.0));
  EXPECT_THAT(std::string(figure.Validate().message()), HasSubstr("\"late\""));
  figure = Good();
  figure.panels[0].cells.push_back({0.0, 0.0, 1.5, {"dark"}});
  EXPECT_THAT(std::string(figure.Validate().message()), HasSubstr("1.5"));
  figure = Good();
  figure.panels[0].x.names = {"a"};
  figure.panels[0].x.log = true;
  EXPECT_THAT(std::string(figure.Validate().message()), HasSubstr("x axis"));
}

TEST(MakeMarker, AlwaysHasAShape) {
  EXPECT_NE(MakeMarker(Role::kTrue, "", 0.0, 0.0).style.marker,
            MarkerShape::kNone);
}

Series Long(int n) {
  Series series = MakeSeries(Role::kMeasured, "y", {}, {});
  for (int i = 0; i < n; ++i) {
    series.x.push_back(1e-6 * (i + 1));
    series.y.push_back(std::sin(0.01 * i));
  }
  return series;
}

TEST(Downsample, DoesNothingUnlessAsked) {
  Series series = Long(5000);
  EXPECT_EQ(Downsample(series, false).x, series.x);
  series.max_points = 5000;
  EXPECT_EQ(Downsample(series, false).y, series.y);
}

TEST(Downsample, KeepsEndsExtremesAndGaps) {
  Series series = Long(10000);
  series.y[1234] = 50.0;
  series.y[7777] = -50.0;
  series.y[4321] = kNaN;
  series.max_points = 300;
  for (const bool log : {false, true}) {
    const Series fewer = Downsample(series, log);
    EXPECT_LE(fewer.x.size(), 301u);  // one more for the gap
    EXPECT_EQ(fewer.x.size(), fewer.y.size());
    EXPECT_EQ(fewer.x.front(), series.x.front());
    EXPECT_EQ(fewer.x.back(), series.x.back());
    EXPECT_TRUE(std::is_sorted(fewer.x.begin(), fewer.x.end()));
    EXPECT_EQ(std::count(fewer.y.begin(), fewer.y.end(), 50.0), 1);
    EXPECT_EQ(std::count(fewer.y.begin(), fewer.y.end(), -50.0), 1);
    EXPECT_EQ(std::count_if(fewer.y.begin(), fewer.y.end(),
                            [](double y) { return std::isnan(y); }),
              1);
  }
}

TEST(Downsample, IsEvenOnTheAxisAsDrawn) {
  Series series = Long(10000);
  series.max_points = 1000;
  const Series fewer = Downsample(series, true);
  // The first of four decades holds 9 points of a uniform grid: all stay.
  const std::vector<double> first(fewer.x.begin(), fewer.x.begin() + 9);
  EXPECT_EQ(first, std::vector<double>(series.x.begin(), series.x.begin() + 9));
}

TEST(Downsample, TheBandStaysWithItsPoints) {
  Series series = Long(2000);
  for (const double y : series.y) {
    series.lower.push_back(y - 1.0);
    series.upper.push_back(y + 2.0);
  }
  series.max_points = 100;
  const Series fewer = Downsample(series, false);
  ASSERT_EQ(fewer.lower.size(), fewer.y.size());
  ASSERT_EQ(fewer.upper.size(), fewer.y.size());
  for (std::size_t i = 0; i < fewer.y.size(); ++i) {
    EXPECT_EQ(fewer.lower[i], fewer.y[i] - 1.0);
    EXPECT_EQ(fewer.upper[i], fewer.y[i] + 2.0);
  }
}

TEST(Downsample, CopesWithDataThatIsNone) {
  Series series = MakeSeries(Role::kMeasured, "", std::vector<double>(50, kNaN),
                             std::vector<double>(50, kNaN));
  series.max_points = 10;
  EXPECT_LE(Downsample(series, true).x.size(), 10u);
}

}  // namespace
}  // namespace mle::report
