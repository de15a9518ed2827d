#include "apps/experiment/campaign.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/nonlinear/smoothed_lasso.h"

namespace mle::experiment {
namespace {

using Rule = SelectionOptions::Rule;

struct NamedRule {
  const char* name;
  Rule rule;
};
constexpr NamedRule kRules[] = {{"paper", Rule::kLeaveChangeOut},
                                {"leave_change_out", Rule::kLeaveChangeOut},
                                {"blocks", Rule::kBlocks},
                                {"aic", Rule::kAic},
                                {"bic", Rule::kBic},
                                {"gcv", Rule::kGcv}};

// The matrix of a weight that is given for every channel, or for each.
absl::Status ExpandWeight(const char* name, int channels,
                          Eigen::MatrixXd& weight) {
  if (weight.rows() == 1) {
    weight = Eigen::VectorXd::Constant(channels, weight(0, 0)).asDiagonal();
  }
  if (weight.rows() == channels) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s has %d values; one is needed, or one for each of %d channels", name,
      weight.rows(), channels));
}

// A model of so many channels that is easy to control, to check options with.
ProcessModel StandIn(const RandomPlants& plants) {
  std::vector<InputChannel> inputs(plants.inputs);
  std::vector<OutputChannel> outputs(plants.outputs);
  for (int j = 0; j < plants.inputs; ++j) inputs[j].name = absl::StrCat("u", j);
  for (int i = 0; i < plants.outputs; ++i) {
    outputs[i].name = absl::StrCat("y", i);
  }
  ProcessModel model("stand-in", "min", inputs, outputs);
  for (int i = 0; i < plants.outputs; ++i) {
    for (int j = 0; j < plants.inputs; ++j) {
      model.element(i, j) = TransferFunction::FirstOrder(
          i == j ? plants.gain.to : plants.gain.from, plants.time_constant.from,
          plants.delay.from);
    }
  }
  return model;
}

absl::Status CheckScenario(const Campaign& campaign, const Scenario& scenario) {
  const ModelSpec& spec = campaign.models[scenario.model];
  const ProcessModel model =
      spec.random.has_value() ? StandIn(*spec.random) : spec.model;
  MLE_ASSIGN_OR_RETURN(
      ExperimentOptions options,
      OptionsOf(campaign, scenario, model.num_outputs(), model.num_inputs()));
  for (const SelectionSpec& selection : campaign.selections) {
    options.correction.selection = selection.options;
    const absl::Status status = options.Validate(model);
    if (status.ok()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("selection '", selection.name, "': ", status.message()));
  }
  return absl::OkStatus();
}

}  // namespace

ControllerSpec::ControllerSpec() {
  constexpr double kOutputWeight = 0.2;
  constexpr double kMoveWeight = 0.1;
  mpc.output_weight = Eigen::MatrixXd::Constant(1, 1, kOutputWeight);
  mpc.move_weight = Eigen::MatrixXd::Constant(1, 1, kMoveWeight);
}

absl::StatusOr<control::MpcOptions> ControllerSpec::For(int outputs,
                                                        int inputs) const {
  control::MpcOptions options = mpc;
  MLE_RETURN_IF_ERROR(
      ExpandWeight("output_weight", outputs, options.output_weight));
  MLE_RETURN_IF_ERROR(ExpandWeight("move_weight", inputs, options.move_weight));
  return options;
}

Campaign::Campaign() {
  controllers.resize(1);
  controllers[0].name = "default";
  windows.resize(1);
  windows[0].name = "default";
  selections = {{"blocks", SelectionOptions()}};
  solvers = {{"homotopy", LassoSolverOptions(), true}};
}

void AddMethods(Method method, Campaign& campaign) {
  if (!method.UsesLambda()) {
    campaign.methods.push_back(method);
    return;
  }
  // Solver by solver: a path is solved once for all rules.
  for (int s = 0; s < static_cast<int>(campaign.solvers.size()); ++s) {
    for (int r = 0; r < static_cast<int>(campaign.selections.size()); ++r) {
      method.selection = r;
      method.solver = s;
      campaign.methods.push_back(method);
    }
  }
}

absl::StatusOr<SelectionOptions> NamedSelection(const std::string& name) {
  std::vector<std::string> known;
  for (const NamedRule& one : kRules) {
    if (name == one.name) {
      SelectionOptions options;
      options.rule = one.rule;
      options.on_grid = name == "paper";
      if (name == "paper") options.horizon = 1;
      return options;
    }
    known.emplace_back(one.name);
  }
  return absl::InvalidArgumentError(
      absl::StrCat("known are ", absl::StrJoin(known, ", ")));
}

absl::StatusOr<SolverSpec> NamedSolver(const std::string& name) {
  SolverSpec spec;
  spec.name = name;
  spec.exact = name == "homotopy";
  if (name == "coordinate_descent") {
    spec.options.solver = LassoSolver::kCoordinateDescent;
  } else if (name == "ceres") {
    spec.options = SmoothedLassoSolver({});
  } else if (!spec.exact) {
    return absl::InvalidArgumentError(
        "known are homotopy, ceres and coordinate_descent");
  }
  return spec;
}

absl::StatusOr<ExperimentOptions> OptionsOf(const Campaign& campaign,
                                            const Scenario& scenario,
                                            int outputs, int inputs) {
  ExperimentOptions options = campaign.settings;
  MLE_ASSIGN_OR_RETURN(
      options.controller,
      campaign.controllers[scenario.controller].For(outputs, inputs));
  options.windows = campaign.windows[scenario.windows];
  options.noise_variance = campaign.noise_variances[scenario.noise];
  const double drift = campaign.drift_variances[scenario.drift];
  if (drift > 0.0) {
    options.conditions.output_disturbance.drift_variance =
        Eigen::VectorXd::Constant(outputs, drift);
  }
  return options;
}

absl::Status CheckScenarios(const Campaign& campaign) {
  const auto count = [](const auto& list) {
    return static_cast<int>(list.size());
  };
  Scenario at;
  for (at.model = 0; at.model < count(campaign.models); ++at.model) {
    for (at.controller = 0; at.controller < count(campaign.controllers);
         ++at.controller) {
      for (at.windows = 0; at.windows < count(campaign.windows); ++at.windows) {
        const absl::Status status = CheckScenario(campaign, at);
        if (status.ok()) continue;
        return absl::InvalidArgumentError(absl::StrCat(
            "model '", campaign.models[at.model].name, "', controller '",
            campaign.controllers[at.controller].name, "', windows '",
            campaign.windows[at.windows].name, "', ", status.message()));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace mle::experiment
