#include "apps/lifecycle/durations.h"

#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle::lifecycle {

absl::StatusOr<double> ParseHours(const std::string& text) {
  constexpr std::pair<const char*, double> kUnits[] = {
      {"s", 1.0 / 3600.0}, {"min", 1.0 / 60.0}, {"h", 1.0},
      {"d", 24.0},         {"w", 168.0},        {"y", kHoursPerYear}};
  const std::size_t end = text.find_first_not_of("0123456789.eE+-");
  double number = 0.0;
  if (end != std::string::npos &&
      absl::SimpleAtod(text.substr(0, end), &number) && std::isfinite(number) &&
      number > 0.0) {
    for (const auto& [name, hours] : kUnits) {
      if (text.substr(end) == name) return number * hours;
    }
  }
  return absl::InvalidArgumentError(
      absl::StrCat("'", text,
                   "' is not a duration; a number > 0 with one of the units "
                   "s, min, h, d, w, y is needed, as in 30d"));
}

TextValue Hours(double* hours, std::string text) {
  TextValue value;
  value.text = std::move(text);
  value.read = [hours](const std::string& given, const NumberRange&) {
    MLE_ASSIGN_OR_RETURN(*hours, ParseHours(given));
    return absl::OkStatus();
  };
  return value;
}

TextValue HoursOrNever(double* hours) {
  TextValue value = Hours(hours, "");
  value.read = [read = value.read](const std::string& given,
                                   const NumberRange& range) {
    return given.empty() ? absl::OkStatus() : read(given, range);
  };
  return value;
}

}  // namespace mle::lifecycle
