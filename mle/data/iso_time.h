// Points in time as historians write them.

#ifndef MLE_DATA_ISO_TIME_H_
#define MLE_DATA_ISO_TIME_H_

#include <optional>
#include <string>
#include <string_view>

namespace mle {

enum class DateOrder {
  kYearFirst,   // 2024-02-29T12:34:56.5+01:00 (ISO 8601)
  kDayFirst,    // 29.02.2024 12:34:56, 29/2/2024 12:34
  kMonthFirst,  // 2/29/2024 12:34:56 PM
};

// What a clock and a calendar show.
struct CivilTime {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0;
  double second = 0.0;      // [0, 60)
  std::optional<int> zone;  // seconds east of UTC, if it was given
};

// Year first: YYYY-MM-DDThh:mm[:ss[.fraction]][zone], also with a blank for T
// and a comma before the fraction. Others: day and month of one or two digits
// with . / or - between, a year of four, then hours (one or two digits) and the
// rest as above, and optionally AM or PM. Zones: Z, UTC, ±hh, ±hhmm, ±hh:mm.
// Nothing for any other text, and for dates and times that do not exist.
std::optional<CivilTime> ParseCivilTime(std::string_view text, DateOrder order);

// Since 1970-01-01T00:00:00Z; without a zone it is taken as UTC.
double SecondsSinceEpoch(const CivilTime& time);

// YYYY-MM-DDThh:mm:ssZ; "?" before the year 1 and after 9999.
std::string FormatIsoTime(double seconds_since_epoch);

// Seconds in a unit of time as process models name it: s, min, h, d and their
// English names; and ms. Nothing for any other text.
std::optional<double> SecondsPerUnit(std::string_view time_unit);

}  // namespace mle

#endif  // MLE_DATA_ISO_TIME_H_
