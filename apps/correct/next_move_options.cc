#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/next_move.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"

namespace mle::correct {
namespace {

constexpr NumberRange kErrorWanted{.min = 0.0, .max = 1.0, .open_min = true};

}  // namespace

std::vector<Option> OptionsOf(NextMoveOptions& move) {
  return {
      {"plan", &move.wanted,
       "Plans set points that tell what these records do not."},
      {"plan_error", &move.error,
       "With --plan: the standard error of each gain that is wanted, relative "
       "to the gain.",
       "", kErrorWanted},
      {"plan_longest", OptionalNumber(&move.longest),
       "With --plan: the longest time from the first move to the last. Empty: "
       "ten settling times of the model.",
       "min", kPositive},
      {"plan_quiet", &move.quiet,
       "With --plan: the least time between moves; 0: a twentieth of the "
       "model's settling time.",
       "min", kNotNegative},
      {"plan_set_points", Words(&move.set_points),
       "With --plan: the outputs whose set points may move, separated by "
       "commas; empty: all."},
      {"plan_min_output", LimitOfEachOutput(&move.min_output, -kInfinity),
       "With --plan: lower limits of the outputs: one value, or one for each "
       "output; none: no limit. Empty: the width of its range in usual "
       "operation below it."},
      {"plan_max_output", LimitOfEachOutput(&move.max_output, kInfinity),
       "With --plan: upper limits of the outputs, as --plan_min_output."},
      {"plan_min_input", LimitOfEachInput(&move.min_input, -kInfinity),
       "With --plan: lower limits of the inputs, as --plan_min_output."},
      {"plan_max_input", LimitOfEachInput(&move.max_input, kInfinity),
       "With --plan: upper limits of the inputs, as --plan_min_output."},
      {"plan_price_squared", OptionalForEachOutput(&move.squared_price),
       "With --plan: price of a squared unit of deviation from the set point "
       "for an hour: one value, or one for each output. Without prices "
       "deviations count in units of usual operation.",
       "", kNotNegative},
      {"plan_price_absolute", OptionalForEachOutput(&move.absolute_price),
       "With --plan: price of a unit of deviation for an hour, as "
       "--plan_price_squared.",
       "", kNotNegative},
  };
}

absl::Status CheckNextMove(const NextMoveOptions& move,
                           const ProcessModel& model) {
  if (!move.wanted) return absl::OkStatus();
  MLE_RETURN_IF_ERROR(AboutOption(
      "plan",
      CheckNotIntegrating(model,
                          "a plan needs outputs that settle where they are "
                          "held")));
  const std::vector<std::string> names = NamesOf(model.outputs());
  for (const std::string& name : move.set_points) {
    if (std::count(names.begin(), names.end(), name) > 0) continue;
    return RefuseOption("plan_set_points", name,
                        absl::StrCat("the model has no such output; it has ",
                                     absl::StrJoin(names, ", ")));
  }
  const bool priced =
      move.squared_price.size() > 0 || move.absolute_price.size() > 0;
  if (priced && !SecondsPerUnit(model.time_unit()).has_value()) {
    return InvalidArgument(
        "--plan_price_squared, --plan_price_absolute: prices "
        "are for hours, and the model's time unit is '",
        model.time_unit(), "'");
  }
  if (priced && move.squared_price.isZero(0.0) &&
      move.absolute_price.isZero(0.0)) {
    return InvalidArgument(
        "--plan_price_squared, --plan_price_absolute: a "
        "price must be > 0");
  }
  return absl::OkStatus();
}

}  // namespace mle::correct
