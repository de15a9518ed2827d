#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "absl/time/civil_time.h"
#include "absl/time/time.h"
#include "apps/report/layout.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::report {
namespace {

using ::testing::ElementsAre;

absl::TimeZone Berlin() {
  absl::TimeZone zone;
  EXPECT_TRUE(absl::LoadTimeZone("Europe/Berlin", &zone));
  return zone;
}

double SecondsAt(int year, int month, int day, int hour = 0, int minute = 0,
                 absl::TimeZone zone = absl::UTCTimeZone()) {
  return absl::ToDoubleSeconds(
      absl::FromCivil(absl::CivilSecond(year, month, day, hour, minute), zone) -
      absl::UnixEpoch());
}

std::vector<std::string> DateLabels(double minutes, int wanted,
                                    const DateScale& dates) {
  std::vector<std::string> labels;
  for (const Tick& tick : DateTicks({0.0, minutes}, dates, wanted)) {
    labels.push_back(tick.label);
  }
  return labels;
}

TEST(DateTicks, Examples) {
  const DateScale dates{.origin = SecondsAt(2024, 3, 4, 6),
                        .seconds_per_unit = 60.0};
  EXPECT_THAT(DateLabels(1200.0, 5, dates),
              ElementsAre("06:00", "12:00", "18:00", "5 Mar"));
  EXPECT_THAT(DateLabels(0.5, 5, dates),
              ElementsAre("06:00:00", "06:00:10", "06:00:20", "06:00:30"));
  EXPECT_THAT(DateLabels(30.0 * 24.0 * 60.0, 5, dates),
              ElementsAre("11 Mar", "18 Mar", "25 Mar", "1 Apr"));
  EXPECT_THAT(DateLabels(365.0 * 24.0 * 60.0, 5, dates),
              ElementsAre("Apr 2024", "Jul 2024", "Oct 2024", "Jan 2025"));
  EXPECT_THAT(DateLabels(365.0 * 24.0 * 60.0 * 8.0, 5, dates),
              ElementsAre("2026", "2028", "2030", "2032"));
  // No two whole seconds: numbers.
  EXPECT_THAT(DateLabels(0.02, 2, dates), ElementsAre("0.00", "0.01", "0.02"));
}

// Midnight stays midnight when clocks change; the hour left out has no tick.
TEST(DateTicks, FollowTheClocksOfTheZone) {
  const DateScale spring{.origin = SecondsAt(2024, 3, 30, 23, 0, Berlin()),
                         .seconds_per_unit = 3600.0,
                         .zone = Berlin()};
  std::vector<double> values;
  std::vector<std::string> labels;
  for (const Tick& tick : DateTicks({0.0, 5.0}, spring, 6)) {
    values.push_back(tick.value);
    labels.push_back(tick.label);
  }
  EXPECT_THAT(labels, ElementsAre("23:00", "31 Mar", "01:00", "03:00", "04:00",
                                  "05:00"));
  EXPECT_THAT(values, ElementsAre(0.0, 1.0, 2.0, 3.0, 4.0, 5.0));
}

TEST(DateTicks, LieInTheRangeInOrderAndAreFew) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(0.5, 10.0);
  std::uniform_real_distribution<double> origin(-1e9, 4e9);
  for (int trial = 0; trial < 2000; ++trial) {
    const DateScale dates{
        .origin = origin(random),
        .seconds_per_unit = trial % 3 == 0 ? 1.0 : 60.0,
        .zone = trial % 2 == 0 ? absl::UTCTimeZone() : Berlin()};
    const double length =
        std::pow(10.0, exponent(random)) / dates.seconds_per_unit;
    const Range range{0.3 * length, 1.3 * length};
    const int wanted = 2 + trial % 6;
    const std::vector<Tick> ticks = DateTicks(range, dates, wanted);
    EXPECT_LE(ticks.size(), static_cast<std::size_t>(wanted) + 2u) << length;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      EXPECT_GE(ticks[i].value, range.min);
      EXPECT_LE(ticks[i].value, range.max);
      EXPECT_FALSE(ticks[i].label.empty());
      if (i > 0) {
        EXPECT_GT(ticks[i].value, ticks[i - 1].value);
      }
      // On a whole second.
      const double seconds =
          dates.origin + ticks[i].value * dates.seconds_per_unit;
      EXPECT_NEAR(seconds, std::round(seconds), 1e-4);
    }
  }
}

}  // namespace
}  // namespace mle::report
