#include "mle/base/number_range.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"

namespace mle {

bool NumberRange::Contains(double value) const {
  if (std::isinf(value)) {
    return infinite && value > 0.0 && max == std::numeric_limits<double>::max();
  }
  return (open_min ? value > min : value >= min) &&
         (open_max ? value < max : value <= max);
}

std::string NumberRange::Describe() const {
  const bool below = min > std::numeric_limits<double>::lowest();
  const bool above = max < std::numeric_limits<double>::max();
  if (below && above) {
    return absl::StrFormat("in %s%.10g, %.10g%s", open_min ? "(" : "[", min,
                           max, open_max ? ")" : "]");
  }
  if (below) return absl::StrFormat("%s %.10g", open_min ? ">" : "≥", min);
  if (above) return absl::StrFormat("%s %.10g", open_max ? "<" : "≤", max);
  return "";
}

absl::Status ValidateSampleTime(std::string_view name, double sample_time) {
  if (kSampleTime.Contains(sample_time)) return absl::OkStatus();
  return InvalidArgument(
      std::string(name), " is ", sample_time, ", must be ",
      sample_time > 0.0 ? kSampleTime.Describe() : "positive");
}

}  // namespace mle
