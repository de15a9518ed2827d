#include "apps/common/controller_options.h"

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"

namespace mle {

std::vector<Option> OptionsOf(control::MpcOptions& mpc) {
  NumberRange ratio = kNotNegative;
  ratio.infinite = true;
  return {
      {"control_period", &mpc.control_period,
       "Control period Δt_c, a multiple of --sample_time.", "min", kPositive},
      {"prediction_horizon", &mpc.prediction_horizon, "Prediction horizon H_p.",
       "control periods", AtLeast(1)},
      {"control_horizon", &mpc.control_horizon, "Control horizon H_c ≤ H_p.",
       "control periods", AtLeast(1)},
      {"output_weight", ForEachOutput(&mpc.output_weight, "0.2"),
       "Weight Q_y on tracking errors: one value, or one for each output, "
       "separated by commas.",
       "", kNotNegative},
      {"move_weight", ForEachInput(&mpc.move_weight, "0.1"),
       "Weight Q_u on input moves: one value, or one for each input.", "",
       kNotNegative},
      {"disturbance_variance_ratio", &mpc.disturbance_variance_ratio,
       "Disturbance observer: increment variance of the output disturbance "
       "over the noise variance.",
       "", ratio},
  };
}

std::vector<Option> OptionsOf(control::MpcLimits& limits) {
  return {
      {"min_input", LimitOfEachInput(&limits.min_input, -kInfinity),
       "Lower limits of the inputs in the controller: one value, or one for "
       "each input; none: no limit. Empty: no limits."},
      {"max_input", LimitOfEachInput(&limits.max_input, kInfinity),
       "Upper limits of the inputs in the controller, as --min_input."},
      {"max_move", LimitOfEachInput(&limits.max_move, kInfinity),
       "Largest move of each input in a control period, as --min_input.", "",
       kNotNegative},
      {"min_output", LimitOfEachOutput(&limits.min_output, -kInfinity),
       "Lower limits of the outputs in the controller (soft): one value, or "
       "one for each output; none: no limit."},
      {"max_output", LimitOfEachOutput(&limits.max_output, kInfinity),
       "Upper limits of the outputs in the controller (soft), as "
       "--min_output."},
      {"output_limit_cost", ForEachOutput(&limits.output_limit_cost, "1000"),
       "Weight of the squared violation of an output limit in the controller: "
       "one value, or one for each output.",
       "", kPositive},
  };
}

absl::Status CheckController(const control::MpcOptions& mpc,
                             const ProcessModel& model) {
  const absl::Status status =
      mpc.Validate(model.num_outputs(), model.num_inputs());
  if (status.ok()) return status;
  return absl::InvalidArgumentError(absl::StrCat(
      "controller (--prediction_horizon, --control_horizon, --output_weight, "
      "--move_weight, --disturbance_variance_ratio and limits): ",
      status.message()));
}

}  // namespace mle
