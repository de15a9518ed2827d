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
#include "mle/data/clock_options.h"
#include "mle/data/time_pattern.h"

namespace mle {

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

// The form of kPattern, whose name is the pattern. InvalidArgument as of
// TimePattern::Create().
absl::StatusOr<TimeForm> FormOfPattern(std::string_view pattern);

// By any of the form's patterns; nothing for other text.
std::optional<CivilTime> ReadCivilTime(std::string_view text,
                                       const TimeForm& form);

// One of TimeForms().
const TimeForm& FormOf(TimeFormat format);

}  // namespace mle

#endif  // MLE_DATA_TIME_FORMAT_H_
