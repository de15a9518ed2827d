#include "mle/data/iso_time.h"

#include <array>

#include "mle/data/csv_numbers.h"

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

bool IsLeap(int year) {
  return year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
}

bool DateExists(int year, int month, int day) {
  constexpr std::array<int, 12> kDays = {31, 28, 31, 30, 31, 30,
                                         31, 31, 30, 31, 30, 31};
  if (month < 1 || month > 12 || day < 1) return false;
  return day <= kDays[month - 1] + (month == 2 && IsLeap(year) ? 1 : 0);
}

// Days since 1970-01-01, for years from 1 on.
int DaysFromCivil(int year, int month, int day) {
  if (month <= 2) --year;
  const int era = year / 400;
  const int year_of_era = year - 400 * era;
  const int month_from_march = month > 2 ? month - 3 : month + 9;
  const int day_of_year = (153 * month_from_march + 2) / 5 + day - 1;
  const int day_of_era =
      365 * year_of_era + year_of_era / 4 - year_of_era / 100 + day_of_year;
  return 146097 * era + day_of_era - 719468;
}

// [Z|±hh:mm], the rest of the text, as seconds east of UTC.
bool TakeZone(std::string_view text, int& seconds) {
  seconds = 0;
  if (text.empty() || text == "Z") return true;
  const int sign = text[0] == '-' ? -1 : 1;
  int hours = 0;
  int minutes = 0;
  if (!TakeOneOf(text, "+-") || !TakeNumber(text, 2, hours)) return false;
  TakeOneOf(text, ":");
  if (!text.empty() && !TakeNumber(text, 2, minutes)) return false;
  seconds = sign * (3600 * hours + 60 * minutes);
  return text.empty() && hours < 24 && minutes < 60;
}

}  // namespace

std::optional<double> ParseIsoTime(std::string_view text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, zone = 0;
  if (!TakeNumber(text, 4, year) || !TakeOneOf(text, "-") ||
      !TakeNumber(text, 2, month) || !TakeOneOf(text, "-") ||
      !TakeNumber(text, 2, day) || !TakeOneOf(text, "Tt ") ||
      !TakeNumber(text, 2, hour) || !TakeOneOf(text, ":") ||
      !TakeNumber(text, 2, minute)) {
    return std::nullopt;
  }
  double second = 0.0;
  if (TakeOneOf(text, ":")) {
    const std::size_t end = text.find_first_not_of("0123456789.");
    const std::string_view digits = text.substr(0, end);
    if (digits.size() < 2 || digits[0] == '.' || digits[1] == '.' ||
        !ReadCsvNumber(digits, second)) {
      return std::nullopt;
    }
    text.remove_prefix(digits.size());
  }
  if (!TakeZone(text, zone) || year < 1 || !DateExists(year, month, day) ||
      hour > 23 || minute > 59 || second >= 60.0) {
    return std::nullopt;
  }
  return 86400.0 * DaysFromCivil(year, month, day) + 3600.0 * hour +
         60.0 * minute + second - zone;
}

std::optional<double> SecondsPerUnit(std::string_view time_unit) {
  struct Unit {
    double seconds;
    std::array<std::string_view, 5> names;
  };
  constexpr Unit kUnits[] = {
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
