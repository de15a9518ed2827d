#include "apps/common/price_options.h"

#include "absl/strings/str_cat.h"
#include "apps/report/text.h"

namespace mle {
namespace {

constexpr int kLongestCurrency = 12;

}  // namespace

std::vector<Option> OptionsOf(control::Prices& prices) {
  return {
      {"price_squared_error", ForEachOutput(&prices.squared_error, "10000"),
       "Price of a squared unit of deviation from the set point for an hour: "
       "one value, or one for each output.",
       "", kNotNegative},
      {"price_absolute_error", ForEachOutput(&prices.absolute_error, "0"),
       "Price of a unit of deviation from the set point for an hour: one "
       "value, or one for each output.",
       "", kNotNegative},
      {"price_violation", ForEachOutput(&prices.violation, "1000"),
       "Price of a unit beyond an output limit for an hour: one value, or one "
       "for each output.",
       "", kNotNegative},
      {"price_movement", ForEachInput(&prices.movement, "0.1"),
       "Price of a unit of input movement: one value, or one for each input.",
       "", kNotNegative},
      {"price_test_hour", &prices.test_hour,
       "Price of an hour of step test, in addition to the product made in it.",
       "", kNotNegative},
      {"price_engineer_hour", &prices.engineer_hour,
       "Price of an engineer's hour.", "", kNotNegative},
      {"hours_per_update", &prices.hours_per_update,
       "Engineer's time for a proposed correction.", "h", kNotNegative},
      {"hours_per_test", &prices.hours_per_test,
       "Engineer's time for a step test.", "h", kNotNegative},
  };
}

absl::Status CheckCurrency(const std::string& name) {
  const int width = report::DisplayWidth(report::CleanText(name));
  if (width <= kLongestCurrency) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("is ", width, " characters long; at most ", kLongestCurrency,
                   " are shown: EUR"));
}

}  // namespace mle
