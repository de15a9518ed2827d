#include "apps/reproduce/request.h"

#include <limits>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/command_line.h"
#include "apps/common/controller_options.h"
#include "apps/common/did_you_mean.h"
#include "apps/experiment/experiment_options.h"
#include "apps/reproduce/cases.h"
#include "mle/base/status.h"

namespace mle::reproduce {
namespace {

using experiment::Ablation;
using experiment::Campaign;

constexpr NumberRange kSeeds = Between(1, 10'000);

std::vector<Option> CaseOptions(Request& request) {
  return {
      {"cases", &request.cases,
       "Cases to run, of the Wood-Berry column: gain (both reflux gains "
       "halved), delay (both steam dead times 4 min longer)."},
      {"model", &request.model_path,
       "Process model (JSON) of the controller; with --plants instead of "
       "--cases."},
      {"plants", &request.plants,
       "NAME:FILE,… process models (JSON) of aged plants, one for each case, "
       "with the inputs and outputs of --model."},
  };
}

std::vector<Option> RunOptions(Request& request) {
  return {
      {"seeds", &request.seeds, "Number of noise seeds for each case.", "",
       kSeeds},
      {"first_seed", &request.first_seed, "First of the consecutive seeds."},
      {"out", &request.folder,
       "Folder for report.html, results.json, the curves and figures."},
      {"figures", &request.figures,
       "Draw the figures (PNG and PDF need rsvg-convert)."},
      {"threads", &request.reproduction.threads,
       "Threads; 0: one for each processor. The results do not depend on the "
       "number.",
       "", kNotNegative},
  };
}

std::vector<Option> MethodOptions(Request& request) {
  Campaign& campaign = request.reproduction.campaign;
  std::vector<std::string> ablations;
  for (const Ablation& one : experiment::Ablations()) {
    ablations.emplace_back(one.name);
  }
  return {
      {"lambda_grid_max", &request.lambda_grid_max, "Largest candidate for λ.",
       "", kPositive},
      {"lambda_grid_step", &request.lambda_grid_step,
       "Step between the candidates for λ; the first candidate is 0.", "",
       kPositive},
      {"solver", SolverOf(&campaign.solvers.front()),
       "Lasso solver. ceres and coordinate_descent are slow: use a coarse "
       "grid."},
      {"estimators", Words(&request.estimators),
       "Estimators to compare on the same records, of arx (ΔR, exact), ceres "
       "(ΔR by smoothed L1; first seed only), output_error (gains, time "
       "constants, dead times), combined (output_error, and shapes that it "
       "lacks) and none (the "
       "initial model), each as in mle_correct or with another test of no "
       "change behind a colon, such as arx:adequacy: calibrated, chi_square, "
       "adequacy (arx and ceres only) or none; empty for no comparison."},
      {"ablations", Words(&request.ablations),
       absl::StrCat("Decisions to be taken differently, one at a time, to "
                    "measure their effect: all, or some of ",
                    absl::StrJoin(ablations, ", "), "; empty: none.")},
      {"ablation_seeds", &request.reproduction.ablation_seeds,
       "Number of the first seeds that --ablations uses.", "", AtLeast(1)},
  };
}

// All but that of mle_study alone; `rule` is --selection itself.
std::vector<Option> SelectionOptionsOf(experiment::SelectionSpec& selection) {
  std::vector<Option> options =
      experiment::Prefixed("selection_", OptionsOf(selection));
  Find(options, "selection_rule").name = "selection";
  return Only(options, {"selection", "selection_folds", "selection_block",
                        "selection_phases", "selection_horizon",
                        "selection_per_output", "selection_one_standard_error",
                        "selection_response_deviations"});
}

absl::Status ReadSeeds(const Request& request,
                       std::vector<std::uint64_t>& seeds) {
  const auto count = static_cast<std::uint64_t>(request.seeds);
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  if (request.first_seed > kLargest - (count - 1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--first_seed=", request.first_seed, ": --seeds=", request.seeds,
        " of them go beyond the largest, ", kLargest));
  }
  for (std::uint64_t s = 0; s < count; ++s) {
    seeds.push_back(request.first_seed + s);
  }
  return absl::OkStatus();
}

absl::Status ReadEstimators(const Request& request,
                            std::vector<experiment::Method>& estimators) {
  std::set<std::string> names;
  for (const std::string& name : request.estimators) {
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
  return absl::OkStatus();
}

absl::Status ReadAblations(const Request& request,
                           std::vector<const Ablation*>& ablations) {
  for (const std::string& name : request.ablations) {
    std::vector<std::string> known = {"all"};
    bool found = false;
    for (const Ablation& one : experiment::Ablations()) {
      known.emplace_back(one.name);
      if (name != "all" && name != one.name) continue;
      ablations.push_back(&one);
      found = true;
    }
    if (found) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "--ablations: there is no ablation '", name, "'; ",
        DidYouMean(name, known), "known are ", absl::StrJoin(known, ", ")));
  }
  const std::set<const Ablation*> different(ablations.begin(), ablations.end());
  if (different.size() == ablations.size()) return absl::OkStatus();
  return RefuseOption("ablations", absl::StrJoin(request.ablations, ","),
                      "an ablation is named twice");
}

}  // namespace

Request::Request() { reproduction.campaign.name = "reproduction"; }

void AddOptions(Request& request, OptionTable& table) {
  Campaign& campaign = request.reproduction.campaign;
  experiment::ExperimentOptions& settings = campaign.settings;
  table.Add("Cases", CaseOptions(request));
  table.Add("Run", RunOptions(request));
  table.Add("Records", Only(OptionsOf(settings), {"sample_time"}));
  table.Add("Records",
            {{"noise_variance", &campaign.noise_variances.front(),
              "Variance σ² of the white measurement noise of every output.", "",
              kNotNegative}});
  table.Add("Records",
            Only(OptionsOf(campaign.windows.front()),
                 {"duration", "step_time", "setpoint_step", "window"}));
  table.Add("Controller", OptionsOf(campaign.controllers.front().mpc));
  table.Add("Conversion", Only(OptionsOf(settings), {"order", "scaling"}));
  table.Add("Conversion",
            experiment::Prefixed("conversion_", ConversionOptionsOf(settings)));
  table.Add("Method", MethodOptions(request));
  table.Add("Method", Only(OptionsOf(settings), {"response_horizon"}));
  table.Add("Choice of λ", SelectionOptionsOf(campaign.selections.front()));
  table.PutFirst({"cases", "model", "plants", "seeds", "out", "figures",
                  "noise_variance", "estimators", "ablations", "selection"});
}

absl::Status Complete(Request& request, OptionTable& table) {
  Reproduction& reproduction = request.reproduction;
  Campaign& campaign = reproduction.campaign;
  MLE_RETURN_IF_ERROR(ReadSeeds(request, campaign.seeds));
  reproduction.threads = UsableThreads(reproduction.threads);
  MLE_RETURN_IF_ERROR(ReadCases(request));
  const ProcessModel& initial = campaign.models.front().model;
  MLE_RETURN_IF_ERROR(table.FitTo(initial));
  MLE_RETURN_IF_ERROR(ReadAblations(request, campaign.ablations));
  MLE_RETURN_IF_ERROR(ReadEstimators(request, reproduction.estimators));
  if (campaign.solvers.front().name != "ceres") {
    campaign.settings.conversion.solver = campaign.solvers.front().options;
  }
  absl::StatusOr<Eigen::VectorXd> grid =
      MakeLambdaGrid(request.lambda_grid_max, request.lambda_grid_step);
  if (!grid.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--lambda_grid_max, --lambda_grid_step: ", grid.status().message()));
  }
  campaign.settings.correction.lambdas = *std::move(grid);
  MLE_ASSIGN_OR_RETURN(const experiment::ExperimentOptions options,
                       reproduction.Options());
  return options.Validate(initial);
}

}  // namespace mle::reproduce
