#include "apps/reproduce/flags.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/loop_flags.h"
#include "apps/reproduce/case_flags.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"

DEFINE_int32(seeds, 1, "Number of noise seeds for each case, 1 … 10000.");
DEFINE_uint64(first_seed, 1, "First of the consecutive seeds.");
DEFINE_string(out, "results",
              "Folder for report.html, results.json, the curves and figures.");
DEFINE_bool(figures, true, "Draw the figures (PNG and PDF need rsvg-convert).");
DEFINE_int32(threads, 0,
             "Threads; 0: one for each processor. The results do not depend on "
             "the number.");

DEFINE_int32(order, 150, "Order d of the ARX model, in samples, ≥ 1.");
DEFINE_string(conversion_noise_variance, "",
              "Noise variance of the conversion of the initial model, ≥ 0; "
              "empty: --noise_variance; 0: without noise.");
DEFINE_double(conversion_penalty, 1e-6, "Penalty λ₀ of the conversion, ≥ 0.");
DEFINE_double(conversion_duration, 10000.0,
              "Length of the excitation for the conversion (min).");
DEFINE_double(duration, 1000.0, "Length of each closed-loop run (min).");
DEFINE_double(step_time, 500.0, "Time of the set-point change in a run (min).");
DEFINE_double(setpoint_step, 1.0, "Size of the set-point changes.");
DEFINE_double(window, 200.0,
              "Length of a run kept before and after the change (min).");
DEFINE_double(response_horizon, 100.0,
              "Length NΔt of the step responses compared (min).");
DEFINE_double(lambda_grid_max, 1e-2, "Largest candidate for λ.");
DEFINE_double(lambda_grid_step, 1e-6,
              "Step between the candidates for λ; the first candidate is 0.");
DEFINE_string(selection, "blocks",
              "Rule for λ: blocks (cross-validation over blocks of every "
              "set-point change), paper (folds are set-point changes, λ on the "
              "grid), leave_change_out (the same over all λ), aic, bic, gcv.");
DEFINE_int32(selection_folds, 5, "Folds of --selection=blocks, ≥ 2.");
DEFINE_int32(selection_block, 0,
             "Length of a block of --selection=blocks, in samples; 0: twice "
             "--order.");
DEFINE_int32(selection_phases, 2,
             "Number of times --selection=blocks cuts the records, each "
             "shifted by that part of a block, ≥ 1.");
DEFINE_int32(
    selection_horizon, -1,
    "Samples predicted in cross-validation before measured outputs are used "
    "again; 1: one step ahead, 0: the whole window (simulation), -1: a fifth "
    "of --order. Always 1 with --selection=paper.");
DEFINE_bool(selection_one_standard_error, false,
            "Select the largest λ whose loss is within one standard error of "
            "the smallest.");
DEFINE_bool(selection_per_output, false, "Choose a λ for each output.");
DEFINE_string(solver, "homotopy",
              "Lasso solver: homotopy (exact), ceres (smoothed L1; the "
              "conversion stays exact) or coordinate_descent. ceres and "
              "coordinate_descent are slow: use a coarse grid.");
DEFINE_string(estimators, "arx,ceres,structured,combined",
              "Estimators to compare on the same records, of arx (ΔR, exact), "
              "ceres (ΔR by smoothed L1; first seed only), structured (gains, "
              "time constants, dead times), combined (structured, then ΔR) and "
              "none (the initial model), each as in mle_correct or with "
              "another test of no change behind a colon, such as "
              "arx:adequacy: calibrated, chi_square, adequacy (arx and ceres "
              "only) or none; empty for no comparison.");
DEFINE_string(
    ablations, "",
    "Decisions to be taken differently, one at a time, to measure their "
    "effect: all, or some of noise_free_conversion, raw_scaling, matlab_stop, "
    "lambda_per_output, one_standard_error and half_windows; empty: none.");
DEFINE_int32(ablation_seeds, 5,
             "Number of the first seeds that --ablations uses, ≥ 1.");
DEFINE_string(scaling, "standardise",
              "Scaling of the regressors: standardise (centre, unit variance, "
              "as MATLAB's lasso) or raw.");

namespace mle::reproduce {
namespace {

using experiment::Ablation;
using experiment::Campaign;

constexpr int kMaxSeeds = 10000;

absl::Status CheckRuns() {
  if (FLAGS_seeds < 1 || FLAGS_seeds > kMaxSeeds) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--seeds=", FLAGS_seeds, ": from 1 to ", kMaxSeeds, " are possible"));
  }
  if (FLAGS_first_seed > std::numeric_limits<std::uint64_t>::max() -
                             static_cast<std::uint64_t>(FLAGS_seeds - 1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--first_seed=", FLAGS_first_seed, ": --seeds=", FLAGS_seeds,
        " of them go beyond the largest, ",
        std::numeric_limits<std::uint64_t>::max()));
  }
  if (FLAGS_ablation_seeds < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--ablation_seeds=", FLAGS_ablation_seeds, ": it must be at least 1"));
  }
  if (FLAGS_threads < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("--threads=", FLAGS_threads,
                     ": 0 (one for each processor) or more are possible"));
  }
  return absl::OkStatus();
}

absl::StatusOr<double> ConversionNoiseVariance() {
  if (FLAGS_conversion_noise_variance.empty()) return FLAGS_noise_variance;
  double variance = 0.0;
  if (!absl::SimpleAtod(FLAGS_conversion_noise_variance, &variance)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--conversion_noise_variance=", FLAGS_conversion_noise_variance, ": '",
        FLAGS_conversion_noise_variance, "' is not a number"));
  }
  return variance;
}

absl::StatusOr<Eigen::VectorXd> LambdaGrid() {
  absl::StatusOr<Eigen::VectorXd> grid =
      MakeLambdaGrid(FLAGS_lambda_grid_max, FLAGS_lambda_grid_step);
  if (grid.ok()) return grid;
  return absl::InvalidArgumentError(absl::StrCat(
      "--lambda_grid_max, --lambda_grid_step: ", grid.status().message()));
}

// "--flag=value: known are …".
absl::Status Unknown(const char* flag, const std::string& value,
                     const absl::Status& known) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, "=", value, ": ", known.message()));
}

absl::StatusOr<SelectionOptions> SelectionFromFlags() {
  absl::StatusOr<SelectionOptions> named =
      experiment::NamedSelection(FLAGS_selection);
  if (!named.ok()) return Unknown("selection", FLAGS_selection, named.status());
  SelectionOptions selection = *named;
  if (FLAGS_selection_block < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("--selection_block=", FLAGS_selection_block,
                     ": it must be at least 1 sample, or 0 for twice --order"));
  }
  if (FLAGS_selection_horizon < -1) {
    return absl::InvalidArgumentError(
        absl::StrCat("--selection_horizon=", FLAGS_selection_horizon,
                     ": it must be at least 1 sample, 0 for the whole "
                     "window or -1 for a fifth of --order"));
  }
  selection.folds = FLAGS_selection_folds;
  if (FLAGS_selection_phases < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("--selection_phases=", FLAGS_selection_phases,
                     ": it must be at least 1"));
  }
  selection.block_length = FLAGS_selection_block;
  selection.phases = FLAGS_selection_phases;
  if (FLAGS_selection != "paper") selection.horizon = FLAGS_selection_horizon;
  selection.one_standard_error = FLAGS_selection_one_standard_error;
  selection.per_output = FLAGS_selection_per_output;
  return selection;
}

absl::StatusOr<std::vector<experiment::Method>> EstimatorsFromFlags() {
  std::vector<experiment::Method> estimators;
  std::set<std::string> names;
  for (const std::string& name : ParseList(FLAGS_estimators)) {
    const absl::StatusOr<experiment::Method> method =
        experiment::ParseMethod(name);
    if (!method.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--estimators: ", method.status().message()));
    }
    if (!names.insert(method->name()).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("--estimators: '", name, "' is named twice"));
    }
    estimators.push_back(*method);
  }
  return estimators;
}

absl::StatusOr<std::vector<const Ablation*>> AblationsFromFlags() {
  std::vector<const Ablation*> ablations = {nullptr};
  for (const std::string& name : ParseList(FLAGS_ablations)) {
    if (name == "all") {
      for (const Ablation& ablation : experiment::Ablations()) {
        ablations.push_back(&ablation);
      }
      continue;
    }
    const Ablation* const ablation = experiment::FindAblation(name);
    if (ablation == nullptr) {
      std::string known;
      for (const Ablation& one : experiment::Ablations()) {
        absl::StrAppend(&known, ", ", one.name);
      }
      return absl::InvalidArgumentError(
          absl::StrCat("--ablations: there is no ablation '", name,
                       "'; known are all", known));
    }
    ablations.push_back(ablation);
  }
  std::set<const Ablation*> different(ablations.begin(), ablations.end());
  if (different.size() < ablations.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--ablations=", FLAGS_ablations, ": an ablation is named twice"));
  }
  return ablations;
}

absl::StatusOr<Scaling> ScalingFromFlags() {
  if (FLAGS_scaling == "standardise") return Scaling::kStandardise;
  if (FLAGS_scaling == "raw") return Scaling::kRaw;
  return absl::InvalidArgumentError(absl::StrCat(
      "--scaling=", FLAGS_scaling, ": known are standardise and raw"));
}

// What all runs have in common.
absl::Status ReadSettings(const Campaign& campaign,
                          experiment::ExperimentOptions& settings) {
  settings.sample_time = FLAGS_sample_time;
  settings.conversion_duration = FLAGS_conversion_duration;
  MLE_ASSIGN_OR_RETURN(settings.conversion_noise_variance,
                       ConversionNoiseVariance());
  settings.conversion.order = FLAGS_order;
  settings.conversion.penalty = FLAGS_conversion_penalty;
  if (FLAGS_solver != "ceres") {
    settings.conversion.solver = campaign.solvers.front().options;
  }
  settings.response_horizon = FLAGS_response_horizon;
  MLE_ASSIGN_OR_RETURN(settings.correction.lambdas, LambdaGrid());
  MLE_ASSIGN_OR_RETURN(settings.correction.scaling, ScalingFromFlags());
  settings.conversion.scaling = settings.correction.scaling;
  return absl::OkStatus();
}

absl::Status ReadAxes(Campaign& campaign) {
  for (int s = 0; s < FLAGS_seeds; ++s) {
    campaign.seeds.push_back(FLAGS_first_seed + static_cast<std::uint64_t>(s));
  }
  campaign.noise_variances = {FLAGS_noise_variance};
  MLE_ASSIGN_OR_RETURN(campaign.controllers.front().mpc,
                       ControllerFromFlags(campaign.models.front().model));
  experiment::WindowSpec& windows = campaign.windows.front();
  windows.duration = FLAGS_duration;
  windows.step_time = FLAGS_step_time;
  windows.setpoint_step = FLAGS_setpoint_step;
  windows.window = FLAGS_window;
  campaign.selections.front().name = FLAGS_selection;
  MLE_ASSIGN_OR_RETURN(campaign.selections.front().options,
                       SelectionFromFlags());
  absl::StatusOr<experiment::SolverSpec> solver =
      experiment::NamedSolver(FLAGS_solver);
  if (!solver.ok()) return Unknown("solver", FLAGS_solver, solver.status());
  campaign.solvers.front() = *std::move(solver);
  MLE_ASSIGN_OR_RETURN(campaign.ablations, AblationsFromFlags());
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Reproduction> ReproductionFromFlags() {
  MLE_RETURN_IF_ERROR(CheckRuns());
  Reproduction reproduction;
  Campaign& campaign = reproduction.campaign;
  campaign.name = "reproduction";
  reproduction.ablation_seeds = FLAGS_ablation_seeds;
  // More than there are processors gain nothing.
  reproduction.threads = static_cast<int>(
      std::min(static_cast<unsigned>(FLAGS_threads),
               std::max(std::thread::hardware_concurrency(), 1u)));
  MLE_RETURN_IF_ERROR(ReadCases(reproduction));
  MLE_RETURN_IF_ERROR(ReadAxes(campaign));
  MLE_RETURN_IF_ERROR(ReadSettings(campaign, campaign.settings));
  MLE_ASSIGN_OR_RETURN(reproduction.estimators, EstimatorsFromFlags());
  MLE_ASSIGN_OR_RETURN(const experiment::ExperimentOptions options,
                       reproduction.Options());
  MLE_RETURN_IF_ERROR(options.Validate(campaign.models.front().model));
  return reproduction;
}

Destination DestinationFromFlags() { return {FLAGS_out, FLAGS_figures}; }

}  // namespace mle::reproduce
