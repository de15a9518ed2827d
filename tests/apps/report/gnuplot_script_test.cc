#include "apps/report/gnuplot_script.h"

#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string ScriptOf(const Series& series, bool log = false) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.x.log = panel.y.log = log;
  panel.series.push_back(series);
  const auto layout = MakeLayout(figure);
  return GnuplotScript(figure, *layout, {.name_and_size = "svg"});
}

TEST(QuoteForGnuplot, NothingEndsTheString) {
  EXPECT_EQ(QuoteForGnuplot("it's λ 1"), "\"it\\047s λ \\061\"");
  EXPECT_EQ(QuoteForGnuplot("a\\"), "\"a\\134\"");
  for (int byte = 0; byte < 256; ++byte) {
    const std::string quoted =
        QuoteForGnuplot(std::string(1, static_cast<char>(byte)));
    EXPECT_EQ(quoted.find_first_of("'`\n$@%#;\"", 1), quoted.size() - 1);
  }
}

TEST(GnuplotScript, DataHaveFullPrecision) {
  const std::string script =
      ScriptOf(MakeSeries(Role::kTrue, "", {0.1 + 0.2, 1e-300}, {1e22, -0.5}));
  EXPECT_THAT(script, HasSubstr("0.30000000000000004 1e+22\n1e-300 -0.5\nEOD"));
}

TEST(GnuplotScript, PointsThatCannotBeShownBreakTheLine) {
  EXPECT_THAT(ScriptOf(MakeSeries(Role::kTrue, "", {0, 1, 2, 3, 4},
                                  {1, 2, kNaN, 4, 5})),
              HasSubstr("0 1\n1 2\n\n3 4\n4 5\nEOD"));
  EXPECT_THAT(
      ScriptOf(MakeSeries(Role::kTrue, "", {0, 1, 2, 3}, {1, 2, -3, 4}), true),
      HasSubstr("<< EOD\n\n1 2\n\n3 4\nEOD"));
}

TEST(GnuplotScript, StepsHoldEachValueUntilTheNext) {
  Series series = MakeSeries(Role::kSetPoint, "", {0, 1, 2}, {5, 6, 7});
  series.steps = true;
  EXPECT_THAT(ScriptOf(series), HasSubstr("0 5\n1 5\n1 6\n2 6\n2 7\nEOD"));
}

TEST(GnuplotScript, ABandIsDrawnBelowItsLine) {
  Series series = MakeSeries(Role::kTrue, "", {0, 1}, {5, 6});
  series.lower = {4, 5};
  series.upper = {7, 8};
  const std::string script = ScriptOf(series);
  EXPECT_THAT(script, HasSubstr("0 5 4 7\n1 6 5 8\nEOD"));
  EXPECT_LT(script.find("filledcurves"), script.find("with lines"));
}

TEST(GnuplotScript, CellsAndStretchesLieBehind) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.x.names = {"a", "b"};
  panel.cells.push_back({1.0, 0.0, 0.4, {"word"}});
  panel.spans.push_back(MakeSpan(Role::kWindow, "used", 0.0, 9.0));
  const std::string script =
      GnuplotScript(figure, *MakeLayout(figure), {.name_and_size = "svg"});
  EXPECT_THAT(script, HasSubstr("set object rectangle from first 0.5, first "
                                "-0.5 to first 1.5, first 0.5 behind"));
  EXPECT_THAT(script, HasSubstr("\"word\""));
  // No further than the axis goes.
  EXPECT_THAT(script, HasSubstr("set object rectangle from first 0, graph 0 to "
                                "first 1.5, graph 1 behind"));
}

TEST(GnuplotScript, LinesOutsideTheRangeAreLeftOut) {
  Figure figure;
  Panel& panel = figure.AddPanel("");
  panel.y.range = Range{0.0, 1.0};
  panel.lines.push_back(HorizontalLine(Role::kInitial, "", 0.5));
  auto layout = MakeLayout(figure);
  EXPECT_THAT(GnuplotScript(figure, *layout, {}), HasSubstr("set arrow from"));
  panel.lines[0].value = 2.0;
  layout = MakeLayout(figure);
  EXPECT_THAT(GnuplotScript(figure, *layout, {}),
              Not(HasSubstr("set arrow from")));
}

}  // namespace
}  // namespace mle::report
