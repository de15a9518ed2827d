#include "apps/experiment/campaign.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/option_values.h"
#include "mle/base/status.h"
#include "mle/nonlinear/smoothed_lasso.h"

namespace mle::experiment {
namespace {

// The diagonal matrix of a weight that is given for every channel, or for each.
absl::Status ExpandWeight(const char* name, int channels,
                          Eigen::MatrixXd& weight) {
  const auto expanded = FitToChannels(weight.diagonal(), channels);
  if (!expanded.ok()) {
    return InvalidArgument(name, ": ", expanded.status().message());
  }
  weight = expanded->asDiagonal();
  return absl::OkStatus();
}

// A model of so many channels that is easy to control, to check options with.
ProcessModel StandIn(const RandomPlants& plants) {
  ProcessModel model = ChannelsOf(plants);
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
    return InvalidArgument("selection '", selection.name,
                           "': ", status.message());
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
  selections = {NamedSelections().front()};
  solvers = {NamedSolvers().front()};
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

const std::vector<SelectionSpec>& NamedSelections() {
  using Rule = SelectionOptions::Rule;
  static const auto* const kAll = new std::vector<SelectionSpec>{
      {"blocks", {.rule = Rule::kBlocks}},
      {"paper", {.rule = Rule::kLeaveChangeOut, .horizon = 1, .on_grid = true}},
      {"leave_change_out", {.rule = Rule::kLeaveChangeOut}},
      {"aic", {.rule = Rule::kAic}},
      {"bic", {.rule = Rule::kBic}},
      {"gcv", {.rule = Rule::kGcv}}};
  return *kAll;
}

const std::vector<SolverSpec>& NamedSolvers() {
  static const auto* const kAll = [] {
    auto* const all = new std::vector<SolverSpec>{
        {"homotopy", LassoSolverOptions(), true},
        {"ceres", SmoothedLassoSolver({}), false},
        {"coordinate_descent", LassoSolverOptions(), false}};
    all->back().options.solver = LassoSolver::kCoordinateDescent;
    return all;
  }();
  return *kAll;
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
  const std::vector<sim::Effects>& effects =
      campaign.effects[scenario.effects].of_models;
  if (!effects.empty()) options.effects = effects[scenario.model];
  return options;
}

ProcessModel ChannelsOf(const RandomPlants& plants) {
  std::vector<InputChannel> inputs(plants.inputs);
  std::vector<OutputChannel> outputs(plants.outputs);
  for (int j = 0; j < plants.inputs; ++j) {
    inputs[j].name = absl::StrCat("u", j + 1);
  }
  for (int i = 0; i < plants.outputs; ++i) {
    outputs[i].name = absl::StrCat("y", i + 1);
  }
  return ProcessModel("drawn at random", "min", std::move(inputs),
                      std::move(outputs));
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
        return InvalidArgument(
            "model '", campaign.models[at.model].name, "', controller '",
            campaign.controllers[at.controller].name, "', windows '",
            campaign.windows[at.windows].name, "', ", status.message());
      }
    }
  }
  return absl::OkStatus();
}

namespace {

constexpr std::string_view kNone = "none";
constexpr std::string_view kCeres = "ceres";

}  // namespace

std::string Method::estimator_name() const {
  if (!estimator.has_value()) return std::string(kNone);
  return std::string(solve_by_ceres ? kCeres : NameOf(*estimator));
}

std::string Method::name() const {
  std::string name = estimator_name();
  if (estimator.has_value() && change_test != Method().change_test) {
    absl::StrAppend(&name, ":", std::string(NameOf(change_test)));
  }
  return name;
}

Method PaperMethod() {
  Method method;
  method.estimator = Estimator::kArx;
  method.change_test = ChangeTest::kNone;
  return method;
}

absl::StatusOr<Method> ParseMethod(std::string_view name) {
  Method method;
  if (name == kNone) return method;
  const std::size_t colon = name.find(':');
  const std::string_view estimator = name.substr(0, colon);
  method.solve_by_ceres = estimator == kCeres;
  const absl::StatusOr<Estimator> parsed =
      method.solve_by_ceres ? Estimator::kArx : ParseEstimator(estimator);
  if (!parsed.ok()) {
    return InvalidArgument(parsed.status().message(), ", ", std::string(kCeres),
                           " and ", std::string(kNone));
  }
  method.estimator = *parsed;
  if (colon != std::string_view::npos) {
    MLE_ASSIGN_OR_RETURN(method.change_test,
                         ParseChangeTest(name.substr(colon + 1)));
  }
  EstimationOptions options;
  options.estimator = *method.estimator;
  options.change_test = method.change_test;
  MLE_RETURN_IF_ERROR(options.Validate());
  return method;
}

namespace {

void ConvertWithoutNoise(ExperimentOptions& options) {
  options.conversion_noise_variance = 0.0;
}

void LeaveUnscaled(ExperimentOptions& options) {
  options.conversion.scaling = Scaling::kRaw;
  options.correction.scaling = Scaling::kRaw;
}

// MATLAB's default tolerance. Solving λ by λ takes its time: a coarse grid.
void StopAsMatlab(ExperimentOptions& options) {
  constexpr int kCandidates = 21;
  constexpr double kDecades = 4.0;
  LassoSolverOptions& solver = options.correction.solver;
  solver.solver = LassoSolver::kCoordinateDescent;
  solver.coordinate_descent.stop =
      CoordinateDescentOptions::Stop::kRelativeChange;
  solver.coordinate_descent.tolerance = 1e-4;
  const double largest = options.correction.lambdas.maxCoeff();
  Eigen::VectorXd lambdas(kCandidates + 1);
  lambdas(0) = 0.0;
  for (int i = 1; i <= kCandidates; ++i) {
    lambdas(i) = largest * std::pow(10.0, kDecades * (i - kCandidates) /
                                              (kCandidates - 1));
  }
  options.correction.lambdas = lambdas;
}

void ChoosePerOutput(ExperimentOptions& options) {
  options.correction.selection.per_output = true;
}

void TakeOneStandardError(ExperimentOptions& options) {
  options.correction.selection.one_standard_error = true;
}

void HalveWindows(ExperimentOptions& options) {
  // Half as much is kept, but in whole samples.
  const double samples =
      std::round(0.5 * options.windows.window / options.sample_time);
  options.windows.window = samples * options.sample_time;
}

constexpr Ablation kAblations[] = {
    {"noise_free_conversion", "initial model converted without noise",
     ConvertWithoutNoise, true},
    {"raw_scaling", "regressors not scaled", LeaveUnscaled, true},
    {"matlab_stop", "coordinate descent, stopped as MATLAB's lasso",
     StopAsMatlab, true},
    {"lambda_per_output", "a λ for each output", ChoosePerOutput, false},
    {"one_standard_error", "largest λ within a standard error",
     TakeOneStandardError, false},
    {"half_windows", "windows half as long", HalveWindows, false},
};

}  // namespace

absl::Span<const Ablation> Ablations() { return kAblations; }

const Ablation* FindAblation(const std::string& name) {
  for (const Ablation& ablation : kAblations) {
    if (ablation.name == name) return &ablation;
  }
  return nullptr;
}

}  // namespace mle::experiment
