#include "apps/lifecycle/prices.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"

namespace mle::lifecycle {

std::vector<Option> OptionsOf(Prices& prices) {
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

void Cost::Add(const Cost& other) {
  product += other.product;
  violation += other.violation;
  movement += other.movement;
  test_hours += other.test_hours;
  engineering += other.engineering;
}

absl::StatusOr<double> HoursPerUnit(const std::string& time_unit) {
  const std::vector<std::pair<std::vector<std::string>, double>> units = {
      {{"s", "sec", "second", "seconds"}, 1.0 / 3600.0},
      {{"min", "minute", "minutes"}, 1.0 / 60.0},
      {{"h", "hr", "hour", "hours"}, 1.0},
      {{"d", "day", "days"}, 24.0}};
  for (const auto& [names, hours] : units) {
    for (const std::string& name : names) {
      if (name == time_unit) return hours;
    }
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the time unit '", time_unit, "' is not known; known are s, min, h, d"));
}

Cost CostOf(const ChangeRow& row, const Prices& prices, double hours_per_unit) {
  const Sums total = row.Total();
  Cost cost;
  cost.product =
      hours_per_unit * (prices.squared_error.dot(total.squared_error) +
                        prices.absolute_error.dot(total.absolute_error));
  cost.violation = hours_per_unit * prices.violation.dot(total.violation);
  cost.movement = prices.movement.dot(total.movement);
  if (row.tested()) {
    cost.test_hours = prices.test_hour * hours_per_unit * row.test.time;
    cost.engineering = prices.engineer_hour * prices.hours_per_test;
  } else if (row.outcome == Outcome::kUpdated ||
             row.outcome == Outcome::kRefused ||
             row.outcome == Outcome::kReverted) {
    cost.engineering = prices.engineer_hour * prices.hours_per_update;
  }
  return cost;
}

Cost CostOf(const Life& life, const Prices& prices, double hours_per_unit) {
  Cost cost;
  for (const ChangeRow& row : life.rows) {
    cost.Add(CostOf(row, prices, hours_per_unit));
  }
  return cost;
}

}  // namespace mle::lifecycle
