#include "apps/lifecycle/price_flags.h"

#include <cmath>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"

DEFINE_string(price_squared_error, "10000",
              "Price of a squared unit of deviation from the set point for an "
              "hour: one value, or one for each output.");
DEFINE_string(price_absolute_error, "0",
              "Price of a unit of deviation from the set point for an hour: "
              "one value, or one for each output.");
DEFINE_string(price_violation, "1000",
              "Price of a unit beyond an output limit for an hour: one value, "
              "or one for each output.");
DEFINE_string(
    price_movement, "0.1",
    "Price of a unit of input movement: one value, or one for each input.");
DEFINE_double(
    price_test_hour, 100.0,
    "Price of an hour of step test, in addition to the product made in it.");
DEFINE_double(price_engineer_hour, 100.0, "Price of an engineer's hour.");
DEFINE_double(hours_per_update, 1.0,
              "Engineer's hours for a proposed correction.");
DEFINE_double(hours_per_test, 16.0, "Engineer's hours for a step test.");

namespace mle::lifecycle {
namespace {

template <typename Value>
absl::Status Refuse(const char* flag, Value value, const char* wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, "=", value, ": ", wanted));
}

absl::StatusOr<Eigen::VectorXd> NumbersFromZero(const char* flag,
                                                const std::string& value,
                                                int count) {
  MLE_ASSIGN_OR_RETURN(Eigen::VectorXd numbers,
                       ParseNumbers(flag, value, count));
  if ((numbers.array() >= 0.0).all()) return numbers;
  return Refuse(flag, value, "no value may be negative");
}

}  // namespace

absl::StatusOr<Prices> PricesFromFlags(const ProcessModel& model) {
  const int p = model.num_outputs();
  Prices prices;
  MLE_ASSIGN_OR_RETURN(
      prices.squared_error,
      NumbersFromZero("price_squared_error", FLAGS_price_squared_error, p));
  MLE_ASSIGN_OR_RETURN(
      prices.absolute_error,
      NumbersFromZero("price_absolute_error", FLAGS_price_absolute_error, p));
  MLE_ASSIGN_OR_RETURN(
      prices.violation,
      NumbersFromZero("price_violation", FLAGS_price_violation, p));
  MLE_ASSIGN_OR_RETURN(prices.movement,
                       NumbersFromZero("price_movement", FLAGS_price_movement,
                                       model.num_inputs()));
  const std::pair<const char*, double> numbers[] = {
      {"price_test_hour", FLAGS_price_test_hour},
      {"price_engineer_hour", FLAGS_price_engineer_hour},
      {"hours_per_update", FLAGS_hours_per_update},
      {"hours_per_test", FLAGS_hours_per_test}};
  for (const auto& [flag, value] : numbers) {
    if (!std::isfinite(value) || value < 0.0) {
      return Refuse(flag, value, "it must be finite and not negative");
    }
  }
  prices.test_hour = FLAGS_price_test_hour;
  prices.engineer_hour = FLAGS_price_engineer_hour;
  prices.hours_per_update = FLAGS_hours_per_update;
  prices.hours_per_test = FLAGS_hours_per_test;
  return prices;
}

}  // namespace mle::lifecycle
