#include "mle/data/time_names.h"

#include <cstdio>
#include <optional>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "mle/data/set_point_windows.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kMarch = 1709532300.0;  // 2024-03-04T06:05:00Z

TEST(TimeNamesTest, NumbersHaveTheUnit) {
  const TimeNames times("min", {});
  EXPECT_FALSE(times.has_dates());
  EXPECT_EQ(times.At(53.25), "53.25 min");
  EXPECT_EQ(times.Span(53.0, 170.5), "53 to 170.5 min");
  EXPECT_EQ(times.Iso(0.0), std::nullopt);
  EXPECT_EQ(TimeNames().At(7.0), "7");
  // A unit that is not of time.
  EXPECT_EQ(TimeNames("shift", kMarch).At(2.0), "2 shift");
}

TEST(TimeNamesTest, DatesHaveSecondsWhereThereAreAny) {
  const TimeNames times("min", kMarch);
  EXPECT_EQ(times.At(0.0), "2024-03-04 06:05");
  EXPECT_EQ(times.At(-1.5), "2024-03-04 06:03:30");
  EXPECT_EQ(times.Span(0.0, 1440.0), "2024-03-04 06:05 to 2024-03-05 06:05");
  EXPECT_EQ(times.unit(), "UTC");
  EXPECT_EQ(times.Iso(60.0), "2024-03-04T07:05:00+00:00");
  EXPECT_EQ(TimeNames("h", kMarch).At(2.0), "2024-03-04 08:05");
}

TEST(TimeNamesTest, DatesAreInTheZoneOfTheRecords) {
  const TimeNames times("min", kMarch, "Europe/Berlin");
  EXPECT_EQ(times.At(0.0), "2024-03-04 07:05");
  EXPECT_EQ(times.unit(), "Europe/Berlin");
  EXPECT_EQ(times.Iso(0.0), "2024-03-04T07:05:00+01:00");
}

// Reports of the import and warnings of windows name dates.
TEST(TimeNamesTest, ReportsAndWarningsHaveDates) {
  ProcessModel tank("tank", "min", {{"steam", ""}}, {{"level", ""}});
  tank.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 0.0);
  std::string text = "time,level,level_setpoint,steam\n";
  for (int k = 0; k < 60; ++k) {
    const int minute = k < 30 ? k : k + 20;
    char row[64];
    std::snprintf(row, sizeof(row), "2024-03-04 %02d:%02d,1,%d,2\n",
                  6 + minute / 60, minute % 60, k >= 59 ? 1 : 0);
    text += row;
  }
  const auto import =
      ImportHistorianSources({TextSource("a.csv", text)}, tank, {});
  ASSERT_TRUE(import.ok()) << import.status();
  const std::string report = import->report.FullReport("min");
  EXPECT_THAT(report, HasSubstr("2024-03-04 06:00 to 2024-03-04 07:19"));
  EXPECT_THAT(report, HasSubstr("gap: 2024-03-04 06:29 to 2024-03-04 06:50"));
  WindowOptions options;
  options.times = import->report.Times("min");
  const auto windows = FindWindows(import->records, tank, options);
  ASSERT_TRUE(windows.ok()) << windows.status();
  ASSERT_FALSE(windows->warnings.empty());
  EXPECT_THAT(windows->warnings[0],
              HasSubstr("the change at 2024-03-04 07:19 has 0 samples"));
}

}  // namespace
}  // namespace mle
