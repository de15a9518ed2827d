// How the times of a record are written, and what they count.

#ifndef MLE_DATA_CLOCK_OPTIONS_H_
#define MLE_DATA_CLOCK_OPTIONS_H_

#include <string>

namespace mle {

enum class TimeFormat {
  kRecognise,         // a form that is certain, as the first row has it
  kNumbers,           // in ClockOptions::number_unit
  kIso,               // 2024-02-29T12:34:56Z, with another zone or none
  kDayFirst,          // 29.02.2024 12:34:56, 29/2/24 12:34
  kMonthFirst,        // 2/29/2024 12:34:56 PM
  kYearFirst,         // 2024/02/29 12:34:56
  kMonthName,         // 29-Feb-24 12:34:56.0
  kExcel,             // 45351.5242: days since 1899-12-30
  kUnix,              // 1709210096: seconds since 1970
  kUnixMilliseconds,  // 1709210096000
  kPattern,           // ClockOptions::pattern
};

struct ClockOptions {
  TimeFormat format = TimeFormat::kRecognise;
  // The pattern of times for kPattern (time_format.h).
  std::string pattern = {};
  // Unit of times that are numbers: ms, s, min, h, d; empty: the model's.
  std::string number_unit = {};
  // Time zone of dates that state none, as the IANA names it ("Europe/Berlin");
  // empty: UTC, or local time that has no change of clocks in it.
  std::string time_zone = {};
};

}  // namespace mle

#endif  // MLE_DATA_CLOCK_OPTIONS_H_
