// The forms of times that a historian writes, each with its name.
//
// A form is a list of patterns (time_pattern.h), or a unit and an origin of
// numbers. A certain form can be recognised from one time; the others must be
// declared, since 3/4 may be the third of April or the fourth of March.

#ifndef MLE_DATA_TIME_FORMAT_H_
#define MLE_DATA_TIME_FORMAT_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/time_pattern.h"

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

// Numbers that stand for dates.
struct SerialTime {
  double seconds_per_unit = 1.0;
  double origin = 0.0;  // seconds since the epoch
};

struct TimeForm {
  TimeFormat format = TimeFormat::kNumbers;
  std::string name;     // "day_first"
  std::string example;  // "29.02.2024 12:34"
  bool is_certain = false;
  std::vector<TimePattern> patterns;  // of dates
  std::optional<SerialTime> serial;
};

// All but kPattern.
const std::vector<TimeForm>& TimeForms();

// Of kPattern, whose name is the pattern. InvalidArgument as of
// TimePattern::Create().
absl::StatusOr<TimeForm> FormOfPattern(std::string_view pattern);

// By any of the form's patterns; nothing for other text.
std::optional<CivilTime> ReadCivilTime(std::string_view text,
                                       const TimeForm& form);

// One of TimeForms().
const TimeForm& FormOf(TimeFormat format);

}  // namespace mle

#endif  // MLE_DATA_TIME_FORMAT_H_
