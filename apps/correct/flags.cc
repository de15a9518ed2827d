#include "apps/correct/flags.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/correct/record_flags.h"
#include "apps/correct/solver_flags.h"
#include "control/mpc_options.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"
#include "mle/model/process_model.h"

DEFINE_string(
    model, "",
    "Process model (JSON) of the controller, to be corrected. Must be given.");
DEFINE_string(data, "",
              "Records (CSV) of routine operation with set-point changes, "
              "separated by commas. Must be given.");
DEFINE_string(out, "correction",
              "Folder for report.html, result.json, arx.json, fopdt.json and "
              "step_response.csv.");
DEFINE_string(truth, "",
              "Process model (JSON) of a simulated plant: its step responses "
              "are shown as the truth.");
DEFINE_bool(dry_run, false, "Only read the records and report on them.");
DEFINE_bool(
    figures, true,
    "Draw the figures, for the page and as files (SVG; PNG and PDF need "
    "rsvg-convert).");
DEFINE_int32(threads, 0,
             "Threads; 0: one for each processor. The results do not depend on "
             "the number.");

DEFINE_string(estimator, "combined",
              "structured (gains, time constants and dead times of the model's "
              "elements), arx (any shape of response, by regularised "
              "regression) or combined (structured, and arx for the outputs "
              "whose structure a test rejects).");
DEFINE_double(response_horizon, 0.0,
              "Length NΔt of the step responses (min); 0: the model's "
              "settling time.");

DEFINE_double(false_alarm_probability, 0.01,
              "Probability, in (0, 1), of a false alarm of the test of no "
              "change, and of naming an element that has not changed.");
DEFINE_double(confidence, 0.95,
              "Confidence level of the intervals, in (0, 1).");
DEFINE_bool(drift, true,
            "The noise may drift (a random walk in the outputs); the size of "
            "the drift is estimated.");
DEFINE_double(max_time_constant_factor, 10.0,
              "Largest factor, > 1, by which a time constant may differ from "
              "the model's.");
DEFINE_double(max_delay, 0.0,
              "Largest dead time of the search (min); 0: twice the model's "
              "dead time plus its time constant.");

DEFINE_int32(order, 0,
             "Order d of the ARX model, in samples; 0: 1.25 times the largest "
             "sum of dead time and time constant of an element.");
DEFINE_double(conversion_penalty, 1e-6,
              "Penalty λ₀ of the conversion to an ARX model, ≥ 0.");
DEFINE_int32(
    conversion_samples, 50000,
    "Number of samples of the excitation for the conversion to an ARX model.");
DEFINE_uint64(
    seed, 1,
    "Seed of the simulations: the excitation for the conversion, and records "
    "of the initial model that calibrate the test of no change.");
DEFINE_string(selection, "blocks",
              "Rule for λ with --estimator=arx: blocks, leave_change_out, aic, "
              "bic, gcv.");

DEFINE_int32(
    validation_folds, 5,
    "Maximum number of folds of the hold-out validation over windows, ≥ 2.");
DEFINE_int32(prediction_samples, 0,
             "Prediction horizon of the compared fits, in samples; 0: a fifth "
             "of --order.");

DEFINE_double(control_period, 0.0,
              "Control period of the controller, a multiple of the sample time "
              "(min); 0: unknown, the advice then compares the tuning by "
              "published rules for the two models.");
DEFINE_int32(prediction_horizon, 30,
             "Prediction horizon of the controller, in control periods.");
DEFINE_int32(control_horizon, 5,
             "Control horizon of the controller, in control periods.");
DEFINE_string(output_weight, "0.2",
              "Weight of the controller on tracking errors, ≥ 0: one value, or "
              "one for each output, separated by commas.");
DEFINE_string(move_weight, "0.1",
              "Weight of the controller on input moves, ≥ 0: one value, or one "
              "for each input.");
DEFINE_double(disturbance_variance_ratio, 0.1,
              "Disturbance observer of the controller: increment variance of "
              "the output disturbance over the noise variance, ≥ 0.");

namespace mle::correct {
namespace {

absl::Status Of(const char* flag, const absl::Status& status) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, ": ", status.message()));
}

template <typename Value>
absl::Status Refuse(const char* flag, Value value, const std::string& wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, "=", value, ": ", wanted));
}

// A length of time, 0 for the default.
absl::Status CheckTime(const char* flag, double value) {
  if (std::isfinite(value) && value >= 0.0) return absl::OkStatus();
  return Refuse(flag, value,
                "it must be a time > 0, or 0 for the default (see --help)");
}

absl::Status CheckNumbers() {
  MLE_RETURN_IF_ERROR(CheckTime("response_horizon", FLAGS_response_horizon));
  MLE_RETURN_IF_ERROR(CheckTime("max_delay", FLAGS_max_delay));
  MLE_RETURN_IF_ERROR(CheckTime("control_period", FLAGS_control_period));
  const std::pair<const char*, int> not_negative[] = {
      {"threads", FLAGS_threads},
      {"order", FLAGS_order},
      {"prediction_samples", FLAGS_prediction_samples}};
  for (const auto& [flag, value] : not_negative) {
    if (value < 0) return Refuse(flag, value, "it must not be negative");
  }
  if (FLAGS_validation_folds < 2) {
    return Refuse("validation_folds", FLAGS_validation_folds,
                  "at least 2 are needed");
  }
  const std::pair<const char*, double> probabilities[] = {
      {"false_alarm_probability", FLAGS_false_alarm_probability},
      {"confidence", FLAGS_confidence}};
  for (const auto& [flag, value] : probabilities) {
    if (!(value > 0.0 && value < 1.0)) {
      return Refuse(flag, value, "it must lie between 0 and 1");
    }
  }
  if (!(FLAGS_max_time_constant_factor > 1.0) ||
      !std::isfinite(FLAGS_max_time_constant_factor)) {
    return Refuse("max_time_constant_factor", FLAGS_max_time_constant_factor,
                  "it must be larger than 1");
  }
  if (!(FLAGS_conversion_penalty >= 0.0) ||
      !std::isfinite(FLAGS_conversion_penalty)) {
    return Refuse("conversion_penalty", FLAGS_conversion_penalty,
                  "it must be finite and not negative");
  }
  if (FLAGS_conversion_samples < 100 || FLAGS_conversion_samples > 10'000'000) {
    return Refuse("conversion_samples", FLAGS_conversion_samples,
                  "from 100 to 10,000,000 are possible");
  }
  return absl::OkStatus();
}

absl::Status ReadModels(Request& request) {
  if (FLAGS_model.empty() || FLAGS_data.empty()) {
    return absl::InvalidArgumentError(
        "--model=FILE.json and --data=A.csv,B.csv must be given (see --help)");
  }
  request.model_path = FLAGS_model;
  absl::StatusOr<ProcessModel> model = ReadProcessModel(FLAGS_model);
  if (!model.ok()) return Of("model", model.status());
  request.model = *std::move(model);
  if (!(SettlingTime(request.model) > 0.0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--model: ", FLAGS_model,
        " has no element with a time constant or a dead time: there is "
        "nothing to correct"));
  }
  if (FLAGS_truth.empty()) return absl::OkStatus();
  request.truth_path = FLAGS_truth;
  absl::StatusOr<ProcessModel> truth = ReadProcessModel(FLAGS_truth);
  if (!truth.ok()) return Of("truth", truth.status());
  if (const absl::Status same =
          CheckSameChannels(request.model, FLAGS_model, *truth, FLAGS_truth);
      !same.ok()) {
    return Of("truth", same);
  }
  request.truth = *std::move(truth);
  return absl::OkStatus();
}

absl::Status ReadDataPaths(Request& request) {
  request.data_paths = ParseList(FLAGS_data);
  if (request.data_paths.empty()) {
    return absl::InvalidArgumentError("--data names no file");
  }
  std::set<std::string> seen;
  for (const std::string& path : request.data_paths) {
    if (!seen.insert(path).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("--data: '", path, "' is named twice"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<Estimator> EstimatorFromFlags() {
  const absl::StatusOr<Estimator> estimator = ParseEstimator(FLAGS_estimator);
  if (!estimator.ok()) {
    return Refuse("estimator", FLAGS_estimator,
                  std::string(estimator.status().message()));
  }
  return *estimator;
}

absl::StatusOr<SelectionOptions> SelectionFromFlags() {
  using Rule = SelectionOptions::Rule;
  const std::map<std::string, Rule> rules = {
      {"blocks", Rule::kBlocks},
      {"leave_change_out", Rule::kLeaveChangeOut},
      {"aic", Rule::kAic},
      {"bic", Rule::kBic},
      {"gcv", Rule::kGcv}};
  const auto rule = rules.find(FLAGS_selection);
  if (rule == rules.end()) {
    return Refuse("selection", FLAGS_selection,
                  "known are blocks, leave_change_out, aic, bic and gcv");
  }
  SelectionOptions selection;
  selection.rule = rule->second;
  return selection;
}

absl::StatusOr<EstimationOptions> EstimationFromFlags() {
  EstimationOptions options;
  MLE_ASSIGN_OR_RETURN(options.estimator, EstimatorFromFlags());
  StructuredOptions& structured = options.structured;
  structured.max_time_scale_factor = FLAGS_max_time_constant_factor;
  if (FLAGS_max_delay > 0.0) structured.max_delay = FLAGS_max_delay;
  structured.estimate_drift = FLAGS_drift;
  structured.false_alarm_probability = FLAGS_false_alarm_probability;
  structured.confidence = FLAGS_confidence;
  options.conversion.order = FLAGS_order;
  options.conversion.penalty = FLAGS_conversion_penalty;
  options.conversion.samples = FLAGS_conversion_samples;
  options.conversion.seed = FLAGS_seed;
  options.calibration.seed = FLAGS_seed;
  MLE_ASSIGN_OR_RETURN(options.correction.selection, SelectionFromFlags());
  MLE_RETURN_IF_ERROR(SetSolver(options));
  return options;
}

absl::StatusOr<ControllerSettings> ControllerFromFlags(
    const ProcessModel& model) {
  ControllerSettings settings;
  settings.control_period = FLAGS_control_period;
  settings.prediction_horizon = FLAGS_prediction_horizon;
  settings.control_horizon = FLAGS_control_horizon;
  settings.disturbance_variance_ratio = FLAGS_disturbance_variance_ratio;
  MLE_ASSIGN_OR_RETURN(
      settings.output_weight,
      ParseNumbers("output_weight", FLAGS_output_weight, model.num_outputs()));
  MLE_ASSIGN_OR_RETURN(
      settings.move_weight,
      ParseNumbers("move_weight", FLAGS_move_weight, model.num_inputs()));
  control::MpcOptions options;
  options.prediction_horizon = settings.prediction_horizon;
  options.control_horizon = settings.control_horizon;
  options.output_weight = settings.output_weight.asDiagonal();
  options.move_weight = settings.move_weight.asDiagonal();
  options.disturbance_variance_ratio = settings.disturbance_variance_ratio;
  if (const absl::Status status =
          options.Validate(model.num_outputs(), model.num_inputs());
      !status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "controller (--prediction_horizon, --control_horizon, "
        "--output_weight, --move_weight, --disturbance_variance_ratio): ",
        status.message()));
  }
  return settings;
}

}  // namespace

absl::StatusOr<Request> RequestFromFlags() {
  MLE_RETURN_IF_ERROR(CheckNumbers());
  Request request;
  MLE_RETURN_IF_ERROR(ReadModels(request));
  MLE_RETURN_IF_ERROR(ReadDataPaths(request));
  request.out = FLAGS_out;
  CorrectOptions& options = request.options;
  MLE_ASSIGN_OR_RETURN(request.import, ImportOptionsFromFlags(request.model));
  MLE_ASSIGN_OR_RETURN(options.records, RecordOptionsFromFlags());
  MLE_ASSIGN_OR_RETURN(options.estimation, EstimationFromFlags());
  options.hold_out.max_folds = FLAGS_validation_folds;
  options.hold_out.horizon = FLAGS_prediction_samples;
  options.response_horizon = FLAGS_response_horizon;
  MLE_ASSIGN_OR_RETURN(request.controller, ControllerFromFlags(request.model));
  // More than there are processors gain nothing.
  options.threads = static_cast<int>(
      std::min(static_cast<unsigned>(FLAGS_threads),
               std::max(std::thread::hardware_concurrency(), 1u)));
  request.dry_run = FLAGS_dry_run;
  request.figures = FLAGS_figures;
  return request;
}

}  // namespace mle::correct
