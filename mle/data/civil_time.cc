#include "mle/data/civil_time.h"

#include <array>
#include <chrono>
#include <cmath>

#include "absl/time/time.h"

namespace mle {
namespace {

std::chrono::year_month_day DateOf(const CivilTime& time) {
  return std::chrono::year(time.year) /
         std::chrono::month(static_cast<unsigned>(time.month)) /
         std::chrono::day(static_cast<unsigned>(time.day));
}

}  // namespace

bool Exists(const CivilTime& time) {
  return time.year >= 1 && DateOf(time).ok() && time.hour >= 0 &&
         time.hour < 24 && time.minute >= 0 && time.minute < 60 &&
         time.second >= 0.0 && time.second < 60.0;
}

CivilTime WithoutHour24(const CivilTime& time) {
  const bool ends_day = time.hour == 24 && time.minute == 0 &&
                        time.second == 0.0 && time.year >= 1 &&
                        DateOf(time).ok();
  if (!ends_day) return time;
  const std::chrono::year_month_day next =
      std::chrono::sys_days(DateOf(time)) + std::chrono::days(1);
  CivilTime result = time;
  result.year = static_cast<int>(next.year());
  result.month = static_cast<int>(static_cast<unsigned>(next.month()));
  result.day = static_cast<int>(static_cast<unsigned>(next.day()));
  result.hour = 0;
  return result;
}

double SecondsSinceEpoch(const CivilTime& time) {
  const auto days = std::chrono::sys_days(DateOf(time)).time_since_epoch();
  return 86400.0 * static_cast<double>(days.count()) + 3600.0 * time.hour +
         60.0 * time.minute + time.second - time.zone.value_or(0);
}

std::string FormatIsoTime(double seconds_since_epoch) {
  const absl::TimeZone utc = absl::UTCTimeZone();
  if (!(seconds_since_epoch >= -62135596800.0) ||
      !(seconds_since_epoch < 253402300800.0)) {
    return "?";
  }
  return absl::FormatTime(
      "%E4Y-%m-%dT%H:%M:%SZ",
      absl::FromUnixMillis(std::llround(1e3 * seconds_since_epoch)), utc);
}

std::optional<double> SecondsPerUnit(std::string_view time_unit) {
  struct Unit {
    double seconds;
    std::array<std::string_view, 5> names;
  };
  constexpr Unit kUnits[] = {
      {1e-3, {"ms"}},
      {1.0, {"s", "sec", "second", "seconds"}},
      {60.0, {"min", "minute", "minutes"}},
      {3600.0, {"h", "hr", "hour", "hours"}},
      {86400.0, {"d", "day", "days"}},
  };
  for (const Unit& unit : kUnits) {
    for (const std::string_view name : unit.names) {
      if (!name.empty() && time_unit == name) return unit.seconds;
    }
  }
  return std::nullopt;
}

}  // namespace mle
