#include "apps/common/correct_options.h"

namespace mle {
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
                          "any shape of response, by regularised regression"},
                         {"combined", Estimator::kCombined,
                          "output_error, and what shapes of responses the "
                          "structure lacks where the records speak for it"}}),
       "Estimator of the corrected model."},
      {"false_alarm_probability", &output_error.false_alarm_probability,
       "Probability of a false alarm of all tests of no change together, and "
       "of "
       "naming an element that has not changed.",
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
