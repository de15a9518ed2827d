// Pages with figures in a real browser: they can be read at every width, in
// light and dark mode, and ask for nothing from outside.

#include <cmath>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "apps/report/html.h"
#include "apps/report/text.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/apps/report/browser.h"

namespace mle::report {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kHostile[] =
    "<b data-injected=1>x</b>\"'&</script><script>alert(1)</script> "
    "\u202e\U0001F600";

// With minutes, or dates from 4 March 2024, 7:00 in Berlin, on its first axis.
Figure Curves(bool has_dates) {
  Figure figure{.columns = 2};
  Panel& steps = figure.AddPanel("reflux");
  steps.x.label = "time (min)";
  if (has_dates) {
    DateScale dates{.origin = 1709532000.0, .seconds_per_unit = 60.0};
    EXPECT_TRUE(absl::LoadTimeZone("Europe/Berlin", &dates.zone));
    steps.x.dates = dates;
  }
  steps.y.label = "step response";
  std::vector<double> time, value, low, high;
  for (int i = 0; i <= 200; ++i) {
    time.push_back(0.5 * i);
    value.push_back(6.4 * (1.0 - std::exp(-0.03 * i)));
    low.push_back(value.back() - 0.3);
    high.push_back(value.back() + 0.3);
  }
  steps.series.push_back(
      MakeSeries(Role::kCorrected, "corrected", time, value));
  steps.series.back().lower = low;
  steps.series.back().upper = high;
  steps.series.push_back(MakeSeries(Role::kSetPoint, kHostile,
                                    {0.0, 50.0, 100.0}, {0.0, 5.0, 5.0}));
  steps.series.back().steps = true;
  // Gaps, and a point alone between two.
  const double gap = std::nan("");
  steps.series.push_back(MakeSeries(Role::kMeasured, "measured",
                                    {0.0, 10.0, 20.0, 30.0, 40.0, 50.0},
                                    {0.1, 1.2, gap, 3.3, gap, gap}));
  steps.lines.push_back(VerticalLine(Role::kReference, "change", 20.0));
  Panel& loss = figure.AddPanel(kHostile);
  loss.x = {.label = "penalty λ", .log = true};
  loss.y = {.label = "E", .log = true};
  loss.series.push_back(MakeSeries(Role::kCorrected, "corrected",
                                   {0.0, 1e-6, 1e-4, 1e-2},
                                   {9.0, 8.0, 3.0, 4e3}));
  loss.lines.push_back(HorizontalLine(Role::kInitial, "before", 2e4));
  loss.markers.push_back(MakeMarker(Role::kChosen, "chosen", 1e-4, 3.0));
  return figure;
}

std::string Page(bool has_dates) {
  HtmlPage page("Figures");
  page.AddSummary({"Two figures."});
  page.AddWarning("A warning.");
  page.AddFigure(Curves(has_dates), "Curves.", "Rising.");
  Figure map;
  Panel& cells = map.AddPanel("");
  cells.x.names = cells.y.names = {"a", "b"};
  cells.cells.push_back({1.0, 1.0, 1.0, {"gain × 0.5", "p < 10⁻⁹"}});
  page.AddFigure(map, "A map.", "A map.");
  Figure empty;
  empty.AddPanel("nothing in it").x.label = "time (min)";
  page.AddFigure(empty, "Empty.", "None.");
  page.AddRunAgain({.command = "mle_correct", .version = "0.1.0"});
  return page.Render();
}

class FiguresBrowserTest : public ::testing::TestWithParam<Mode> {};

TEST_P(FiguresBrowserTest, CanBeReadAndAsksForNothing) {
  if (!HasBrowser()) GTEST_SKIP() << "no browser is installed";
  const Mode mode = GetParam();
  const bool has_dates = mode == Mode::kDark;
  const std::vector<int> widths = {375, 1024, 1920};
  const auto visits = VisitPage(Page(has_dates), widths, "figures", mode);
  for (std::size_t i = 0; i < widths.size(); ++i) {
    const BrowserVisit& visit = visits[i];
    ASSERT_EQ(visit.error, "");
    const nlohmann::json& found = visit.found;
    EXPECT_THAT(visit.console, IsEmpty());
    EXPECT_EQ(found["width"], widths[i]);
    EXPECT_EQ(found["dark"], mode == Mode::kDark);
    EXPECT_EQ(found["figures"], 3);
    EXPECT_EQ(found["panels"], 4);
    EXPECT_EQ(found["requests"], nlohmann::json::array());
    EXPECT_LE(found["overflow"], 0);
    EXPECT_EQ(found["faint"], nlohmann::json::array());
    EXPECT_EQ(found["overlapping"], nlohmann::json::array());
    EXPECT_GE(found["smallest"], 8.0);
    // Names are text, whatever they hold.
    EXPECT_EQ(found["injected"], 0);
    EXPECT_THAT(found["texts"].get<std::vector<std::string>>(),
                ::testing::Contains(CleanText(kHostile)));
    // The middle of 0 … 100: 6.4·(1 − e⁻³) = 6.08.
    EXPECT_THAT(
        found["readout"].get<std::string>(),
        AllOf(HasSubstr(has_dates ? "at 2024-03-04 07:50:00 " : "at 50 "),
              HasSubstr("corrected 6.08"),
              HasSubstr(CleanText(kHostile) + " 5.00")));
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, FiguresBrowserTest,
                         ::testing::Values(Mode::kLight, Mode::kDark),
                         [](const auto& test) {
                           return test.param == Mode::kDark ? "Dark" : "Light";
                         });

}  // namespace
}  // namespace mle::report
