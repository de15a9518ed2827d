#include "apps/reproduce/request.h"

#include <cstddef>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/built_in_models.h"
#include "apps/common/command_line.h"
#include "apps/common/model_files.h"
#include "apps/common/option_values.h"
#include "apps/common/shared_options.h"
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
       "constants, dead times) and none (the initial model), each as in "
       "mle_correct or with "
       "another test of no change behind a colon, such as arx:adequacy: "
       "calibrated, chi_square, "
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

absl::Status ReadEstimators(const Request& request,
                            std::vector<experiment::Method>& estimators) {
  std::set<std::string> names;
  for (const std::string& name : request.estimators) {
    MLE_ASSIGN_OR_RETURN(
        const experiment::Method method,
        AboutOption("estimators", experiment::ParseMethod(name)));
    if (!names.insert(method.name()).second) {
      return InvalidArgument("--estimators: '", name, "' is named twice");
    }
    estimators.push_back(method);
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
    return InvalidArgument("--ablations: there is no ablation '", name, "'; ",
                           DidYouMean(name, known), "choose from ",
                           absl::StrJoin(known, ", "));
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

namespace {

using experiment::Mismatch;

// Names go into names of files.
absl::Status CheckName(const std::string& name) {
  const bool plain = !name.empty() && name.size() <= 100 &&
                     name.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                         "0123456789_-") == std::string::npos;
  if (plain) return absl::OkStatus();
  return InvalidArgument(
      "--plants: the name '", name,
      "' must be made of letters, digits, '_' and '-', at most 100");
}

absl::StatusOr<std::vector<Mismatch>> ReadPlants(const Request& request,
                                                 const ProcessModel& initial) {
  std::vector<Mismatch> cases;
  for (const std::string& part : ParseList(request.plants)) {
    const std::size_t colon = part.find(':');
    if (colon == std::string::npos) {
      return InvalidArgument("--plants: '", part,
                             "' is not of the form NAME:FILE");
    }
    Mismatch& one = cases.emplace_back();
    one.name = part.substr(0, colon);
    MLE_RETURN_IF_ERROR(CheckName(one.name));
    MLE_ASSIGN_OR_RETURN(one.plant,
                         ReadModelLike(initial, request.model_path, "plants",
                                       part.substr(colon + 1)));
  }
  if (cases.empty()) {
    return absl::InvalidArgumentError("--plants names no plant");
  }
  return cases;
}

absl::StatusOr<std::vector<Mismatch>> BuiltInCases(const Request& request) {
  std::vector<Mismatch> cases;
  for (const std::string& name : ParseList(request.cases)) {
    const BuiltInModel* found = nullptr;
    for (const BuiltInModel& model : kWoodBerryAged) {
      if (model.name == name) found = &model;
    }
    if (found == nullptr) {
      return InvalidArgument(
          "--cases: there is no case '", name, "'; ",
          DidYouMean(name, {"gain", "delay"}),
          "choose from gain and delay, others run with --model and --plants");
    }
    MLE_ASSIGN_OR_RETURN(ProcessModel plant,
                         ParseProcessModel(found->json, found->source));
    Mismatch& one = cases.emplace_back();
    one.name = name;
    one.plant = std::move(plant);
  }
  if (cases.empty()) {
    return absl::InvalidArgumentError("--cases names no case");
  }
  return cases;
}

// Fills in the campaign's model and mismatches: the user's own, or the paper's.
// Errors name the option, and the file if there is one.
absl::Status ReadCases(Request& request) {
  Reproduction& reproduction = request.reproduction;
  experiment::Campaign& campaign = reproduction.campaign;
  campaign.models.resize(1);
  campaign.models.front().name = "initial";
  ProcessModel& initial = campaign.models.front().model;
  const bool own = !request.model_path.empty() || !request.plants.empty();
  if (own && (request.model_path.empty() || request.plants.empty())) {
    return absl::InvalidArgumentError(
        "--model and --plants must be given together: the controller's model, "
        "and the plants");
  }
  if (own && request.cases != kPaperCases) {
    return absl::InvalidArgumentError(
        "--cases stands for plants of the Wood-Berry column; give either "
        "--cases or --model with --plants");
  }
  if (own) {
    MLE_ASSIGN_OR_RETURN(initial, ReadModel("model", request.model_path));
    MLE_RETURN_IF_ERROR(AboutOption(
        "model",
        CheckNotIntegrating(
            initial, "reproductions are those of elements that settle")));
    MLE_ASSIGN_OR_RETURN(campaign.mismatches, ReadPlants(request, initial));
  } else {
    MLE_ASSIGN_OR_RETURN(initial,
                         ParseProcessModel(kWoodBerry.json, kWoodBerry.source));
    MLE_ASSIGN_OR_RETURN(campaign.mismatches, BuiltInCases(request));
    reproduction.from_paper = true;
  }
  std::set<std::string> names;
  for (const Mismatch& one : campaign.mismatches) {
    if (!names.insert(one.name).second) {
      return InvalidArgument(own ? "--plants" : "--cases", ": '", one.name,
                             "' is named twice; every case needs its own name");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Complete(Request& request, OptionTable& table) {
  Reproduction& reproduction = request.reproduction;
  Campaign& campaign = reproduction.campaign;
  MLE_ASSIGN_OR_RETURN(campaign.seeds, experiment::ConsecutiveSeeds(
                                           request.first_seed, request.seeds));
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
    return InvalidArgument("--lambda_grid_max, --lambda_grid_step: ",
                           grid.status().message());
  }
  campaign.settings.correction.lambdas = *std::move(grid);
  MLE_ASSIGN_OR_RETURN(const experiment::ExperimentOptions options,
                       reproduction.Options());
  return options.Validate(initial);
}

}  // namespace mle::reproduce
