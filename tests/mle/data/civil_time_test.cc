#include "mle/data/civil_time.h"

#include <cstdio>
#include <optional>

#include "gtest/gtest.h"
#include "mle/data/time_format.h"

namespace mle {
namespace {

std::optional<double> Seconds(const char* text) {
  const std::optional<CivilTime> time =
      ReadCivilTime(text, FormOf(TimeFormat::kIso));
  if (!time) return std::nullopt;
  return SecondsSinceEpoch(*time);
}

// Seconds from GNU date, as in date -u -d 2024-02-29T12:34:56Z +%s.
TEST(IsoTimeTest, GivesSecondsSinceTheEpoch) {
  EXPECT_EQ(Seconds("1970-01-01T00:00:00Z"), 0.0);
  EXPECT_EQ(Seconds("2024-02-29T12:34:56Z"), 1709210096.0);
  EXPECT_EQ(Seconds("2000-03-01 00:00"), 951868800.0);
  EXPECT_EQ(Seconds("1900-01-01T00:00:00"), -2208988800.0);
  EXPECT_EQ(Seconds("2024-02-29T12:34:56.25"), 1709210096.25);
}

TEST(IsoTimeTest, ZonesAreTakenOff) {
  EXPECT_EQ(Seconds("2024-02-29T14:34:56+02:00"), 1709210096.0);
  EXPECT_EQ(Seconds("2024-02-29T07:04:56-0530"), 1709210096.0);
}

// Every day of 1999 … 2101 follows the one before.
TEST(IsoTimeTest, DaysFollowEachOther) {
  double last = *Seconds("1998-12-31T00:00");
  int days = 0;
  for (int year = 1999; year <= 2101; ++year) {
    for (int month = 1; month <= 12; ++month) {
      for (int day = 1; day <= 31; ++day) {
        char text[32];
        std::snprintf(text, sizeof(text), "%04d-%02d-%02dT00:00", year, month,
                      day);
        const std::optional<double> time = Seconds(text);
        if (!time) continue;
        ASSERT_EQ(*time - last, 86400.0) << text;
        last = *time;
        ++days;
      }
    }
  }
  EXPECT_EQ(days, 103 * 365 + 25);  // 2100 is no leap year.
}

TEST(IsoTimeTest, RefusesWhatDoesNotExist) {
  for (const char* text :
       {"", "12.5", "2024-02-29", "2024-02-30T00:00", "2023-02-29T00:00",
        "2024-13-01T00:00", "2024-00-01T00:00", "2024-01-00T00:00",
        "2024-01-01T24:01", "2024-01-01T00:60", "2024-01-01T00:00:60",
        "2024-01-01T00:00:5", "2024-01-01T00:00:00X", "2024-01-01T00:00:00+1",
        "2024-01-01T00:00:00+25:00", "2024/01/01T00:00", "24-01-01T00:00",
        "2024-01-01T00:00:00Z ", "0000-01-01T00:00"}) {
    EXPECT_FALSE(Seconds(text).has_value()) << text;
  }
}

TEST(IsoTimeTest, KnowsUnitsOfTime) {
  EXPECT_EQ(SecondsPerUnit("min"), 60.0);
  EXPECT_EQ(SecondsPerUnit("hours"), 3600.0);
  EXPECT_EQ(SecondsPerUnit("d"), 86400.0);
  EXPECT_EQ(SecondsPerUnit("s"), 1.0);
  EXPECT_FALSE(SecondsPerUnit("").has_value());
  EXPECT_FALSE(SecondsPerUnit("shift").has_value());
}

TEST(FormatIsoTimeTest, YearsOfThreeDigitsReadBack) {
  const std::optional<double> seconds = Seconds("0901-02-20T00:00:00Z");
  ASSERT_TRUE(seconds.has_value());
  EXPECT_EQ(FormatIsoTime(*seconds), "0901-02-20T00:00:00Z");
}

}  // namespace
}  // namespace mle
