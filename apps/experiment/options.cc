#include "apps/experiment/options.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/option_values.h"
#include "apps/common/shared_options.h"
#include "apps/experiment/campaign.h"
#include "control/mpc.h"
#include "mle/base/status.h"

namespace mle::experiment {
namespace {

absl::Status CheckTimes(const ExperimentOptions& options) {
  for (const auto& [flag, value] :
       {std::pair{"control_period", options.controller.control_period},
        std::pair{"duration", options.windows.run_duration()},
        std::pair{"window", options.windows.window},
        std::pair{"conversion_duration", options.conversion_duration},
        std::pair{"response_horizon", options.response_horizon}}) {
    MLE_RETURN_IF_ERROR(CheckSamples(flag, value, options.sample_time));
  }
  if (options.windows.setpoint_step != 0.0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--setpoint_step=0: it must be other than 0");
}

absl::Status CheckLoop(const ExperimentOptions& options,
                       const ProcessModel& initial) {
  const control::MpcOptions& controller = options.controller;
  MLE_RETURN_IF_ERROR(
      CheckControlPeriod(controller.control_period, options.sample_time));
  if (controller.prediction_horizon < controller.control_horizon) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--control_horizon=%d exceeds --prediction_horizon=%d",
        controller.control_horizon, controller.prediction_horizon));
  }
  for (const InputChannel& input : initial.inputs()) {
    if (input.role == InputRole::kDisturbance) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "input '%s' is a disturbance; this experiment moves every input",
          input.name));
    }
  }
  if (HasTransforms(initial)) {
    return absl::InvalidArgumentError(
        "the model has transforms; experiments have linear models and plants "
        "(mle_simulate simulates others, mle_convert makes linear ones)");
  }
  MLE_RETURN_IF_ERROR(CheckController(controller, initial));
  // Finds the rest, such as weights that leave the moves undetermined.
  const absl::Status created =
      control::Mpc::Create(initial, controller).status();
  if (created.ok()) return created;
  return InvalidArgument("controller: ", created.message());
}

absl::Status CheckRows(const ExperimentOptions& options,
                       const ProcessModel& initial) {
  const double first = options.windows.first_change();
  const double window = options.windows.window;
  const double duration = options.windows.run_duration();
  if (!(first - window >= -1e-9) || !(first + window <= duration + 1e-9)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--window=%g around --step_time=%g reaches from %g to %g, the record "
        "from 0 to --duration=%g",
        window, first, first - window, first + window, duration));
  }
  const int order = options.conversion.order;
  if (options.window_rows() < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--order=%d leaves no rows to learn from: a window of 2 × %g has %d "
        "samples",
        order, window, options.window_rows() + order));
  }
  const double rows =
      std::round(options.conversion_duration / options.sample_time) + 1 - order;
  const double regressors = static_cast<double>(order) *
                            (initial.num_outputs() + initial.num_inputs());
  if (rows < regressors) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--conversion_duration=%g is too short: --order=%d makes %d "
        "coefficients of each output, which take at least %g",
        options.conversion_duration, order, static_cast<long>(regressors),
        (regressors + order) * options.sample_time));
  }
  constexpr int kFewestSamples = 5;  // that a fit of three parameters needs
  if (options.response_samples() < kFewestSamples) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--response_horizon=%g is too short; it must be at least %g, %d times "
        "--sample_time",
        options.response_horizon, (kFewestSamples - 1) * options.sample_time,
        kFewestSamples - 1));
  }
  return absl::OkStatus();
}

absl::Status CheckSelection(const ExperimentOptions& options,
                            const ProcessModel& initial) {
  const SelectionOptions& selection = options.correction.selection;
  const int windows = options.windows.num_changes(initial.num_outputs());
  if (selection.rule == SelectionOptions::Rule::kLeaveChangeOut) {
    if (windows >= 2) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrFormat(
        "--selection=paper and leave_change_out need at least two set-point "
        "changes, one to leave out, not %d: use --selection=blocks",
        windows));
  }
  if (selection.rule != SelectionOptions::Rule::kBlocks)
    return absl::OkStatus();
  const int length = selection.BlockLength(options.conversion.order);
  const int blocks = std::max(options.window_rows() / length, 1) * windows;
  if (blocks < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--selection_block=%d samples makes a single block of the records, "
        "which have %d rows; cross-validation needs at least 2",
        length, options.window_rows() * windows));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckControlPeriod(double control_period, double sample_time) {
  const double ratio = control_period / sample_time;
  if (std::round(ratio) >= 1.0 &&
      std::abs(ratio - std::round(ratio)) <= 1e-9 * ratio) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrFormat(
      "--control_period=%g is not a whole multiple of --sample_time=%g",
      control_period, sample_time));
}

absl::Status ExperimentOptions::Validate(const ProcessModel& initial) const {
  MLE_RETURN_IF_ERROR(CheckTimes(*this));
  MLE_RETURN_IF_ERROR(CheckLoop(*this, initial));
  MLE_RETURN_IF_ERROR(CheckRows(*this, initial));
  MLE_RETURN_IF_ERROR(CheckSelection(*this, initial));
  MLE_RETURN_IF_ERROR(conversion.Validate());
  return correction.Validate();
}

int ExperimentOptions::response_samples() const {
  return static_cast<int>(std::lround(response_horizon / sample_time)) + 1;
}

int ExperimentOptions::window_rows() const {
  return 2 * static_cast<int>(std::lround(windows.window / sample_time)) + 1 -
         conversion.order;
}

namespace {

constexpr double kMaxChannels = 50;
constexpr double kMaxChanges = 1000;

// "1" stands for an interval of one value, where that is possible.
TextValue IntervalOf(Interval* interval, bool one_value) {
  return {.read = [=](const std::string& text, const NumberRange& range) {
    MLE_ASSIGN_OR_RETURN(const Eigen::VectorXd ends, ParseNumbers(text, range));
    if (ends.size() != 2 && !(one_value && ends.size() == 1)) {
      return InvalidArgument(
          "must be ", one_value ? "a number or " : "",
          "a list of two numbers, the smallest and the largest");
    }
    *interval = {ends(0), ends(ends.size() - 1)};
    if (interval->from <= interval->to) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrFormat("the smallest value comes first, but %g is above %g",
                        interval->from, interval->to));
  }};
}

}  // namespace

absl::StatusOr<std::vector<std::uint64_t>> ConsecutiveSeeds(std::uint64_t first,
                                                            int count) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  if (first > kLargest - static_cast<std::uint64_t>(count - 1)) {
    return RefuseOption(
        "first_seed", absl::StrCat(first),
        absl::StrCat("--seeds=", count, " of them go beyond the largest, ",
                     kLargest));
  }
  std::vector<std::uint64_t> seeds(static_cast<std::size_t>(count));
  std::iota(seeds.begin(), seeds.end(), first);
  return seeds;
}

TextValue RuleOf(SelectionSpec* selection) {
  const std::vector<SelectionSpec>& known = NamedSelections();
  std::vector<ChoiceText> choices;
  for (const SelectionSpec& one : known) choices.push_back({one.name, ""});
  choices[0].meaning = "cross-validation over blocks of every set-point change";
  choices[1].meaning = "folds are set-point changes, λ on the grid";
  choices[2].meaning = "the same over all λ";
  return OneOfNames(
      known.front().name, std::move(choices),
      [selection, &known](std::size_t number) {
        const SelectionSpec& chosen = known[number];
        selection->name = chosen.name;
        SelectionOptions& options = selection->options;
        options.rule = chosen.options.rule;
        options.on_grid = chosen.options.on_grid;
        // The paper's rule has one of its own.
        if (chosen.options.horizon != SelectionOptions().horizon) {
          options.horizon = chosen.options.horizon;
        }
      });
}

TextValue SolverOf(SolverSpec* solver) {
  const std::vector<SolverSpec>& known = NamedSolvers();
  std::vector<ChoiceText> choices;
  for (const SolverSpec& one : known) choices.push_back({one.name, ""});
  choices[0].meaning = "exact";
  choices[1].meaning = "smoothed L1; the conversion stays exact";
  return OneOfNames(
      known.front().name, std::move(choices),
      [solver, &known](std::size_t number) { *solver = known[number]; });
}

std::vector<Option> OptionsOf(ExperimentOptions& settings) {
  return {
      {"sample_time", &settings.sample_time,
       "Sample time Δt of records and models.", "min", kPositive},
      {"order", &settings.conversion.order, "Order d of the ARX model.",
       "samples", AtLeast(1)},
      {"response_horizon", &settings.response_horizon,
       "Length NΔt of the step responses compared.", "min", kPositive},
      {"scaling",
       OneOfNames("standardise",
                  {{"standardise", "centre, unit variance, as MATLAB's lasso"},
                   {"raw", ""}},
                  [&settings](std::size_t number) {
                    settings.conversion.scaling =
                        number == 1 ? Scaling::kRaw : Scaling::kStandardise;
                    settings.correction.scaling = settings.conversion.scaling;
                  }),
       "Scaling of the regressors."},
  };
}

std::vector<Option> ConversionOptionsOf(ExperimentOptions& settings) {
  return {
      {"duration", &settings.conversion_duration,
       "Length of the excitation for the conversion of the initial model.",
       "min", kPositive},
      {"penalty", &settings.conversion.penalty, "Penalty λ₀ of the conversion.",
       "", kNotNegative},
      {"noise_variance", OptionalNumber(&settings.conversion_noise_variance),
       "Noise variance of the conversion; empty: --noise_variance; 0: without "
       "noise.",
       "", kNotNegative},
  };
}

std::vector<Option> OptionsOf(WindowSpec& windows) {
  return {
      {"duration", &windows.duration, "Length of each closed-loop run.", "min",
       kPositive},
      {"step_time", &windows.step_time,
       "Time of the set-point change in a run.", "min", kNotNegative},
      {"setpoint_step", &windows.setpoint_step,
       "Size of the set-point changes."},
      {"window", &windows.window,
       "Length of a run kept before and after the change.", "min", kPositive},
      {"changes", &windows.changes, "Number of set-point changes of one run.",
       "", Between(1, kMaxChanges)},
      {"spacing", &windows.spacing, "Time between these changes.", "min",
       kPositive},
      {"outlier_share", &windows.outlier_share,
       "Share of the samples of every output that are outliers.", "",
       Between(0.0, 0.5)},
      {"longest_outlier", &windows.longest_outlier,
       "Longest burst of outliers; 1: single ones.", "samples",
       Between(1, 100)},
      {"robust",
       OneOf<OutlierTreatment>(&windows.robust,
                               {{"none", OutlierTreatment::kNone, ""},
                                {"model", OutlierTreatment::kModel, ""},
                                {"huber", OutlierTreatment::kHuber, ""},
                                {"cauchy", OutlierTreatment::kCauchy, ""}}),
       "What is done about outliers."},
  };
}

std::vector<Option> OptionsOf(SelectionSpec& selection) {
  SelectionOptions& options = selection.options;
  return {
      {"rule", RuleOf(&selection), "Rule for λ."},
      {"folds", &options.folds, "Folds of --selection=blocks.", "", AtLeast(2)},
      {"block", &options.block_length,
       "Length of a block of --selection=blocks; 0: twice --order.", "samples",
       AtLeast(0)},
      {"phases", &options.phases,
       "Number of times --selection=blocks cuts the records, each shifted by "
       "that part of a block.",
       "", AtLeast(1)},
      {"horizon", &options.horizon,
       "Samples predicted in cross-validation before measured outputs are "
       "used again; 1: one step ahead, 0: the whole window (simulation), -1: "
       "a fifth of --order. Always 1 with --selection=paper.",
       "samples", AtLeast(-1)},
      {"per_output", &options.per_output, "Choose a λ for each output."},
      {"one_standard_error", &options.one_standard_error,
       "Select the largest λ whose loss is within one standard error of the "
       "smallest."},
      {"response_deviations", &options.response_deviations,
       "With --selection=blocks: standard deviations by which the estimated "
       "error of the step responses may exceed its least value before another "
       "λ is taken; 0: not checked.",
       "", kNotNegative},
      {"on_grid", &options.on_grid, "λ among the values of the grid."},
  };
}

std::vector<Option> OptionsOf(RandomPlants& plants) {
  return {
      {"outputs", &plants.outputs, "Number of outputs.", "",
       Between(1, kMaxChannels)},
      {"inputs", &plants.inputs, "Number of inputs.", "",
       Between(1, kMaxChannels)},
      {"gain", IntervalOf(&plants.gain, false), "Size of the gains.", "",
       kPositive},
      {"time_constant", IntervalOf(&plants.time_constant, false),
       "Time constants.", "min", kPositive},
      {"delay", IntervalOf(&plants.delay, false), "Dead times.", "min",
       kNotNegative},
      {"max_condition_number", &plants.max_condition_number,
       "Largest condition number of the static gains.", "", AtLeast(1.0)},
      {"max_sensitivity",
       &plants.max_sensitivity,
       "Largest sensitivity peak of the loop.",
       "",
       {.min = 1.0, .open_min = true}},
  };
}

std::vector<Option> OptionsOf(Change& change) {
  return {
      {"output", &change.output, "The output; *: any."},
      {"input", &change.input, "The input; *: any."},
      {"elements", &change.elements, "Number of elements drawn.", "",
       Between(1, kMaxChannels * kMaxChannels)},
      {"gain_factor", IntervalOf(&change.gain_factor, true),
       "Factor of the gain.", "", kPositive},
      {"time_constant_factor", IntervalOf(&change.time_constant_factor, true),
       "Factor of the time constant.", "", kPositive},
      {"delay_shift", IntervalOf(&change.delay_shift, true),
       "Shift of the dead time.", "min"},
  };
}

std::vector<Option> Prefixed(const std::string& prefix,
                             std::vector<Option> options) {
  for (Option& option : options) {
    option.name = absl::StrCat(prefix, option.name);
  }
  return options;
}

}  // namespace mle::experiment
