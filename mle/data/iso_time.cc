#include "mle/data/iso_time.h"

#include <array>
#include <chrono>
#include <cmath>

#include "absl/time/time.h"

namespace mle {
namespace {

// Takes `digits` digits from the front of `text`.
bool TakeNumber(std::string_view& text, int digits, int& number) {
  if (text.size() < static_cast<std::size_t>(digits)) return false;
  number = 0;
  for (const char c : text.substr(0, digits)) {
    if (c < '0' || c > '9') return false;
    number = 10 * number + (c - '0');
  }
  text.remove_prefix(digits);
  return true;
}

bool TakeOneOf(std::string_view& text, std::string_view characters) {
  if (text.empty() || characters.find(text[0]) == std::string_view::npos) {
    return false;
  }
  text.remove_prefix(1);
  return true;
}

std::chrono::year_month_day DateOf(const CivilTime& time) {
  return std::chrono::year(time.year) /
         std::chrono::month(static_cast<unsigned>(time.month)) /
         std::chrono::day(static_cast<unsigned>(time.day));
}

// One or two digits.
bool TakeShortNumber(std::string_view& text, int& number) {
  return TakeNumber(text, 2, number) || TakeNumber(text, 1, number);
}

// [Z|UTC|±hh[[:]mm]], the rest of the text, as seconds east of UTC.
bool TakeZone(std::string_view text, std::optional<int>& seconds) {
  if (text.empty()) return true;
  TakeOneOf(text, " ");
  seconds = 0;
  if (text == "Z" || text == "z" || text == "UTC") return true;
  const int sign = text.starts_with('-') ? -1 : 1;
  int hours = 0;
  int minutes = 0;
  if (!TakeOneOf(text, "+-") || !TakeNumber(text, 2, hours)) return false;
  TakeOneOf(text, ":");
  if (!text.empty() && !TakeNumber(text, 2, minutes)) return false;
  seconds = sign * (3600 * hours + 60 * minutes);
  return text.empty() && hours < 24 && minutes < 60;
}

bool TakeDate(std::string_view& text, DateOrder order, CivilTime& time) {
  if (order == DateOrder::kYearFirst) {
    return TakeNumber(text, 4, time.year) && TakeOneOf(text, "-") &&
           TakeNumber(text, 2, time.month) && TakeOneOf(text, "-") &&
           TakeNumber(text, 2, time.day);
  }
  const bool day_first = order == DateOrder::kDayFirst;
  return TakeShortNumber(text, day_first ? time.day : time.month) &&
         TakeOneOf(text, "./-") &&
         TakeShortNumber(text, day_first ? time.month : time.day) &&
         TakeOneOf(text, "./-") && TakeNumber(text, 4, time.year);
}

// ss[.fraction]
bool TakeSeconds(std::string_view& text, double& seconds) {
  int whole = 0;
  if (!TakeNumber(text, 2, whole)) return false;
  seconds = whole;
  if (!TakeOneOf(text, ".,")) return true;
  double digits = 0.0;
  double scale = 1.0;
  while (!text.empty() && text[0] >= '0' && text[0] <= '9') {
    if (scale < 1e15) {
      digits = 10.0 * digits + (text[0] - '0');
      scale *= 10.0;
    }
    text.remove_prefix(1);
  }
  seconds += digits / scale;
  return true;
}

// [ AM|PM]
bool TakeHalfDay(std::string_view& text, int& hour) {
  std::string_view rest = text;
  TakeOneOf(rest, " ");
  const bool is_pm = rest.starts_with("PM") || rest.starts_with("pm");
  if (!is_pm && !rest.starts_with("AM") && !rest.starts_with("am")) return true;
  if (hour < 1 || hour > 12) return false;
  hour = hour % 12 + (is_pm ? 12 : 0);
  text = rest.substr(2);
  return true;
}

}  // namespace

std::optional<CivilTime> ParseCivilTime(std::string_view text,
                                        DateOrder order) {
  CivilTime time;
  const bool is_iso = order == DateOrder::kYearFirst;
  if (!TakeDate(text, order, time) || !TakeOneOf(text, is_iso ? "Tt " : " T")) {
    return std::nullopt;
  }
  const bool has_hour = is_iso ? TakeNumber(text, 2, time.hour)
                               : TakeShortNumber(text, time.hour);
  if (!has_hour || !TakeOneOf(text, ":") || !TakeNumber(text, 2, time.minute)) {
    return std::nullopt;
  }
  if (TakeOneOf(text, ":") && !TakeSeconds(text, time.second)) {
    return std::nullopt;
  }
  if ((!is_iso && !TakeHalfDay(text, time.hour)) ||
      !TakeZone(text, time.zone) || time.year < 1 || !DateOf(time).ok() ||
      time.hour > 23 || time.minute > 59 || time.second >= 60.0) {
    return std::nullopt;
  }
  return time;
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
