// Points in time: calendar and clock, and seconds since 1970. time_format.h
// reads them.

#ifndef MLE_DATA_CIVIL_TIME_H_
#define MLE_DATA_CIVIL_TIME_H_

#include <optional>
#include <string>
#include <string_view>

namespace mle {

// A date and a time of day, as a calendar and a clock show them.
struct CivilTime {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0;
  double second = 0.0;      // [0, 60)
  std::optional<int> zone;  // seconds east of UTC, if it was given
};

// 24:00, as standards for means of hours write the end of a day, as 00:00 of
// the next; other times stay.
CivilTime WithoutHour24(const CivilTime& time);

// Whether the calendar has that day and the clock that time: years from 1, no
// 30 February, no hour 24, no second 60.
bool Exists(const CivilTime& time);

// Since 1970-01-01T00:00:00Z; without a zone it is taken as UTC.
double SecondsSinceEpoch(const CivilTime& time);

// YYYY-MM-DDThh:mm:ssZ; "?" before the year 1 and after 9999.
std::string FormatIsoTime(double seconds_since_epoch);

// Seconds in a unit of time as process models name it: s, min, h, d and their
// English names; and ms. Nothing for any other text.
std::optional<double> SecondsPerUnit(std::string_view time_unit);

}  // namespace mle

#endif  // MLE_DATA_CIVIL_TIME_H_
