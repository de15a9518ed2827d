// Lengths of time with their unit, as flags have them: "30d", "12h", "0.5y".

#ifndef APPS_LIFECYCLE_DURATIONS_H_
#define APPS_LIFECYCLE_DURATIONS_H_

#include <string>

#include "absl/status/statusor.h"
#include "apps/common/option_values.h"

namespace mle::lifecycle {

inline constexpr double kHoursPerYear = 8766.0;  // 365.25 days

// In hours; units are s, min, h, d, w and y. InvalidArgument unless it is a
// number > 0 with one of them.
absl::StatusOr<double> ParseHours(const std::string& text);

// An option that is a length of time, put into `hours`.
TextValue Hours(double* hours, std::string text);
// The same; blank, the default, leaves the field as it is.
TextValue HoursOrNever(double* hours);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_DURATIONS_H_
