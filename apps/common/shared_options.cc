#include "apps/common/shared_options.h"

#include "apps/report/text.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

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
  return InvalidArgument(
      "controller (--prediction_horizon, --control_horizon, --output_weight, "
      "--move_weight, --disturbance_variance_ratio and limits): ",
      status.message());
}

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
  return InvalidArgument("is ", width, " characters long; at most ",
                         kLongestCurrency, " are shown: EUR");
}

namespace {

constexpr NumberRange kFraction{.min = 0.0, .max = 1.0, .open_max = true};

}  // namespace
namespace {

TextValue RuleForLambda(SelectionOptions& selection) {
  using Rule = SelectionOptions::Rule;
  return OneOf<Rule>(&selection.rule,
                     {{"blocks", Rule::kBlocks, ""},
                      {"leave_change_out", Rule::kLeaveChangeOut, ""},
                      {"aic", Rule::kAic, ""},
                      {"bic", Rule::kBic, ""},
                      {"gcv", Rule::kGcv, ""}});
}

TextValue Solver(EstimationOptions& options) {
  return OneOfNames("homotopy",
                    {{"homotopy", "exact, for all λ"},
                     {"coordinate_descent", ""},
                     {"ceres", "smoothed L1, at the λ of the exact path"}},
                    [&options](std::size_t number) {
                      options.correction.solver.solver =
                          number == 1 ? LassoSolver::kCoordinateDescent
                                      : LassoSolver::kHomotopy;
                      options.solve_by_ceres = number == 2;
                    });
}

}  // namespace

std::vector<Option> OptionsOf(EstimationOptions& options) {
  OutputErrorOptions& output_error = options.output_error;
  ConversionSettings& conversion = options.conversion;
  return {
      {"estimator",
       OneOf<Estimator>(&options.estimator,
                        {{"output_error", Estimator::kOutputError,
                          "gains, time constants and dead times of the model's "
                          "elements"},
                         {"arx", Estimator::kArx,
                          "any shape of response, by regularised "
                          "regression"}}),
       "Estimator of the corrected model."},
      {"false_alarm_probability", &output_error.false_alarm_probability,
       "Probability of a false alarm of all tests of no change together, and "
       "of naming an element that has not changed.",
       "", kProbability},
      {"confidence", &output_error.confidence,
       "Confidence level of the intervals.", "", kProbability},
      {"drift", &output_error.estimate_drift,
       "The noise may drift (a random walk in the outputs); the size of the "
       "drift is estimated."},
      {"max_time_constant_factor",
       &output_error.max_time_scale_factor,
       "Largest factor by which a time constant may differ from the model's.",
       "",
       {.min = 1.0, .open_min = true}},
      {"max_delay", ZeroForInfinity(&output_error.max_delay),
       "Largest dead time of the search; 0: twice the model's dead time plus "
       "its time constant.",
       "min", kNotNegative},
      {"robust",
       OneOf<RobustLoss>(&output_error.robust_loss,
                         {{"none", RobustLoss::kNone, "squares"},
                          {"huber", RobustLoss::kHuber, ""},
                          {"cauchy", RobustLoss::kCauchy, ""}}),
       "Loss of the residuals, for records with bursts and outliers that are "
       "not detected. For ΔR at the λ chosen with squares."},
      {"order", &conversion.order,
       "Order d of the ARX model; 0: 1.25 times the largest sum of dead time "
       "and time constant of an element.",
       "samples", Between(0, 100'000)},
      {"conversion_penalty", &conversion.penalty,
       "Penalty λ₀ of the conversion to an ARX model.", "", kNotNegative},
      {"conversion_samples", &conversion.samples,
       "Number of samples of the excitation for the conversion to an ARX "
       "model.",
       "samples", Between(100, 10'000'000)},
      {"seed", &conversion.seed,
       "Seed of the simulations: the excitation for the conversion, and "
       "records of the initial model that calibrate the test of no change."},
      {"selection", RuleForLambda(options.correction.selection),
       "Rule for λ with --estimator=arx."},
      {"selection_response_deviations",
       &options.correction.selection.response_deviations,
       "With --selection=blocks: standard deviations by which the estimated "
       "error of the step responses may exceed its least value before another "
       "λ is taken; 0: not checked.",
       "", kNotNegative},
      {"solver", Solver(options), "Solver of ΔR."},
  };
}

std::vector<Option> OptionsOf(HoldOutOptions& options) {
  return {
      {"validation_folds", &options.folds,
       "Number of folds of the hold-out validation.", "", Between(2, 1000)},
      {"fewest_changes", &options.fewest_changes,
       "Set-point changes that a window must have for parts of it to be held "
       "out if it is the only one.",
       "", AtLeast(2)},
      {"prediction_samples", &options.horizon,
       "Prediction horizon of the compared fits; 0: a fifth of --order.",
       "samples", kNotNegative},
  };
}

std::vector<Option> OptionsOf(DecisionOptions& options) {
  return {
      {"least_change", &options.least_change,
       "A change of an element's step response, relative to its norm, up to "
       "which it is not worth making.",
       "", kFraction},
      {"clock_error", &options.clock_error,
       "By how much the time stamps of a tag may be late or early, five "
       "samples at least: a change of dead time that a whole row or column of "
       "the model shares is not told from it. 0: clocks are right.",
       "s", kNotNegative},
      {"deviations", &options.deviations,
       "Standard errors by which a held-out score must gain, and may not fall.",
       "", kPositive},
  };
}

}  // namespace mle
