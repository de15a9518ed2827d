#include "apps/experiment/campaign_json.h"

#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "apps/common/option_json.h"
#include "apps/common/shared_options.h"
#include "apps/experiment/grid.h"
#include "mle/base/status.h"
#include "mle/correction/correction.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"
#include "sim/effects_json.h"

namespace mle::experiment {
namespace {

using ParsedJson = nlohmann::json;

// Fails if `name` is in `names` already, which it joins.
absl::Status CheckNewName(const JsonNode& node, const std::string& name,
                          std::set<std::string>& names) {
  if (names.insert(name).second) return absl::OkStatus();
  return node.Fault("the name '", name,
                    "' is duplicated; every entry needs its own");
}

// The list at `key`, whose entries `parse(node, entry)` fills in and names,
// each with a name of its own. Without the key the list stays as it is.
template <typename Entry, typename Parse>
absl::Status ReadNamedList(const JsonNode& node, const std::string& key,
                           const Parse& parse, std::vector<Entry>& list) {
  if (!node.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At(key).Elements());
  list.clear();
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    Entry& entry = list.emplace_back();
    MLE_RETURN_IF_ERROR(parse(element, entry));
    MLE_RETURN_IF_ERROR(CheckNewName(element, entry.name, names));
  }
  return absl::OkStatus();
}

// A list of different numbers.
absl::StatusOr<std::vector<double>> ParseNumberList(const JsonNode& node,
                                                    const NumberRange& range) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<double> numbers;
  std::set<double> seen;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const double number, element.Number(range));
    if (!seen.insert(number).second) {
      return element.Fault(absl::StrFormat("%g is duplicated", number));
    }
    numbers.push_back(number);
  }
  return numbers;
}

constexpr std::int64_t kMaxSeeds = 1'000'000;
// The largest whole number that every JSON reader keeps exactly.
constexpr std::int64_t kMaxSeed = 9'007'199'254'740'991;

// A process model that ResolveCampaign() read in.
absl::StatusOr<ProcessModel> ParseModel(const JsonNode& node) {
  return node.Check(ParseProcessModel(node.json().dump(), "process model"));
}

absl::StatusOr<Change> ParseChange(const JsonNode& node) {
  Change change;
  MLE_RETURN_IF_ERROR(ReadOptionsOnly(node, {}, OptionsOf(change)));
  if (!node.Has("gain_factor") && !node.Has("time_constant_factor") &&
      !node.Has("delay_shift")) {
    return node.Fault(
        "changes nothing: give gain_factor, time_constant_factor or "
        "delay_shift");
  }
  return change;
}

// That a plant file has the channels of every model, or that the changes of
// every model are possible.
absl::Status CheckMismatch(const JsonNode& node, const Mismatch& mismatch,
                           const std::vector<ModelSpec>& models) {
  for (const ModelSpec& spec : models) {
    if (mismatch.plant.has_value()) {
      const absl::Status same =
          spec.random.has_value()
              ? InvalidArgument(
                    "is a plant of its own, but the plants of the model '",
                    spec.name, "' are drawn: give changes instead")
              : CheckSameChannels(spec.model,
                                  absl::StrCat("model '", spec.name, "'"),
                                  *mismatch.plant, "the plant");
      MLE_RETURN_IF_ERROR(node.Check(same));
    } else if (!spec.random.has_value()) {
      const absl::Status possible = CheckAgeing(spec.model, mismatch);
      if (!possible.ok()) {
        return node.Fault("model '", spec.name,
                          "': ", std::string(possible.message()));
      }
    }
  }
  return absl::OkStatus();
}

// A mismatch for each of its sizes.
absl::StatusOr<std::vector<Mismatch>> ParseMismatch(
    const JsonNode& node, const std::vector<ModelSpec>& models) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name"}, {"plant", "changes", "sizes"}));
  Mismatch mismatch;
  MLE_ASSIGN_OR_RETURN(mismatch.name, node.At("name").Name());
  if (node.Has("plant") && node.Has("changes")) {
    return node.Fault("has a plant and changes; only one of them is possible");
  }
  if (node.Has("plant")) {
    MLE_ASSIGN_OR_RETURN(mismatch.plant, ParseModel(node.At("plant")));
  }
  if (node.Has("changes")) {
    MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> changes,
                         node.At("changes").Elements());
    for (const JsonNode& change : changes) {
      MLE_ASSIGN_OR_RETURN(Change parsed, ParseChange(change));
      mismatch.changes.push_back(std::move(parsed));
    }
  }
  std::vector<double> sizes = {1.0};
  if (node.Has("sizes")) {
    if (mismatch.changes.empty()) {
      return node.At("sizes").Fault("only changes have sizes");
    }
    MLE_ASSIGN_OR_RETURN(sizes, ParseNumberList(node.At("sizes"), kAnyNumber));
  }
  std::vector<Mismatch> mismatches;
  for (const double size : sizes) {
    mismatch.size = size;
    MLE_RETURN_IF_ERROR(CheckMismatch(node, mismatch, models));
    mismatches.push_back(mismatch);
  }
  return mismatches;
}

absl::StatusOr<std::vector<std::uint64_t>> ParseSeeds(const JsonNode& node) {
  std::vector<std::uint64_t> seeds;
  if (node.json().is_object()) {
    MLE_RETURN_IF_ERROR(node.CheckKeys({"first", "count"}, {}));
    MLE_ASSIGN_OR_RETURN(const std::int64_t count,
                         node.At("count").Integer(1, kMaxSeeds));
    MLE_ASSIGN_OR_RETURN(const std::int64_t first,
                         node.At("first").Integer(0, kMaxSeed - count));
    for (std::int64_t i = 0; i < count; ++i) {
      seeds.push_back(static_cast<std::uint64_t>(first + i));
    }
    return seeds;
  }
  if (!node.json().is_array()) {
    return node.Fault(
        "must be a list of seeds or {\"first\": …, \"count\": …}, is ",
        node.Found());
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::set<std::int64_t> seen;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const std::int64_t seed, element.Integer(0, kMaxSeed));
    if (!seen.insert(seed).second) {
      return element.Fault("the seed ", seed, " is duplicated");
    }
    seeds.push_back(static_cast<std::uint64_t>(seed));
  }
  return seeds;
}

absl::Status ParseModelSpec(const JsonNode& node, ModelSpec& spec) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name"}, {"file", "model", "random"}));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  if (node.Has("model") == node.Has("random")) {
    return node.Fault(
        "needs one of file (or the model itself, as model) and random");
  }
  if (node.Has("random")) {
    return ReadOptionsOnly(node.At("random"), {},
                           OptionsOf(spec.random.emplace()));
  }
  MLE_ASSIGN_OR_RETURN(spec.model, ParseModel(node.At("model")));
  return node.Check(CheckNotIntegrating(
      spec.model, "campaigns are those of elements that settle"));
}

// Those that name a plant must have the channels of every model.
absl::StatusOr<std::vector<Mismatch>> ParseMismatches(
    const JsonNode& node, const std::vector<ModelSpec>& models) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<Mismatch> mismatches;
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(std::vector<Mismatch> sizes,
                         ParseMismatch(element, models));
    MLE_RETURN_IF_ERROR(CheckNewName(element, sizes.front().name, names));
    for (Mismatch& mismatch : sizes) mismatches.push_back(std::move(mismatch));
  }
  return mismatches;
}

// Effects as in a file of mle_simulate, for the channels of every model.
absl::StatusOr<std::vector<sim::Effects>> ParseEffectsOf(
    const JsonNode& node, const std::vector<ModelSpec>& models) {
  std::vector<sim::Effects> effects;
  for (const ModelSpec& model : models) {
    MLE_ASSIGN_OR_RETURN(effects.emplace_back(),
                         sim::ParseEffects(node, model.random.has_value()
                                                     ? ChannelsOf(*model.random)
                                                     : model.model));
  }
  return effects;
}

absl::Status ParseEffectsSpec(const JsonNode& node,
                              const std::vector<ModelSpec>& models,
                              EffectsSpec& spec) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name"}, {"file", "effects"}));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  if (!node.Has("effects")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(spec.of_models,
                       ParseEffectsOf(node.At("effects"), models));
  return absl::OkStatus();
}

absl::Status ParseController(const JsonNode& node, ControllerSpec& spec) {
  MLE_RETURN_IF_ERROR(
      ReadOptionsOnly(node, {"name"}, mle::OptionsOf(spec.mpc)));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  return absl::OkStatus();
}

absl::Status ParseWindow(const JsonNode& node, WindowSpec& spec) {
  MLE_RETURN_IF_ERROR(ReadOptionsOnly(node, {"name"}, OptionsOf(spec)));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  if (spec.longest_outlier > 1 &&
      spec.longest_outlier < WindowSpec::kShortestBurst) {
    return node.At("longest_outlier")
        .Fault("must be 1, or at least ", WindowSpec::kShortestBurst,
               " for bursts");
  }
  if (spec.changes == 0) {
    if (!node.Has("spacing")) return absl::OkStatus();
    return node.At("spacing").Fault("needs changes, their number");
  }
  for (const char* key : {"duration", "step_time"}) {
    if (!node.Has(key)) continue;
    return node.At(key).Fault(
        "has no place beside changes, which come at window, window + spacing, "
        "…");
  }
  const double least = 2.0 * spec.window;
  if (!node.Has("spacing")) spec.spacing = least;
  return spec.spacing >= least
             ? absl::OkStatus()
             : node.At("spacing").Number(AtLeast(least)).status();
}

absl::Status ParseAxes(const JsonNode& node, Campaign& campaign) {
  MLE_ASSIGN_OR_RETURN(campaign.seeds, ParseSeeds(node.At("seeds")));
  MLE_RETURN_IF_ERROR(
      ReadNamedList(node, "models", ParseModelSpec, campaign.models));
  MLE_ASSIGN_OR_RETURN(campaign.mismatches,
                       ParseMismatches(node.At("mismatches"), campaign.models));
  for (const auto& [key, list] :
       {std::pair{"noise_variances", &campaign.noise_variances},
        std::pair{"drift_variances", &campaign.drift_variances}}) {
    if (!node.Has(key)) continue;
    MLE_ASSIGN_OR_RETURN(*list, ParseNumberList(node.At(key), kNotNegative));
  }
  const auto parse_effects = [&campaign](const JsonNode& element,
                                         EffectsSpec& spec) {
    return ParseEffectsSpec(element, campaign.models, spec);
  };
  MLE_RETURN_IF_ERROR(
      ReadNamedList(node, "effects", parse_effects, campaign.effects));
  MLE_RETURN_IF_ERROR(ReadNamedList(node, "controllers", ParseController,
                                    campaign.controllers));
  return ReadNamedList(node, "windows", ParseWindow, campaign.windows);
}

absl::Status Unknown(const JsonNode& node, absl::string_view known) {
  return node.Fault("is ", node.Found(), "; ", known);
}

// A name from a table, into the field that `value` binds.
absl::Status Choose(const JsonNode& node, const TextValue& value,
                    absl::string_view others = "") {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  const absl::Status status = value.read(name, kAnyNumber);
  if (status.ok()) return status;
  return Unknown(node, absl::StrCat(status.message(), others));
}

absl::Status ParseSelection(const JsonNode& node, SelectionSpec& spec) {
  if (node.json().is_string()) return Choose(node, RuleOf(&spec));
  std::vector<Option> options = OptionsOf(spec);
  options.push_back({"name", &spec.name, ""});
  MLE_RETURN_IF_ERROR(
      ReadOptionsOnly(node, {"name", "rule"}, std::move(options)));
  return node.At("name").Name().status();
}

absl::Status ParseSolver(const JsonNode& node, const Campaign& campaign,
                         SolverSpec& spec) {
  if (!node.json().is_object()) {
    return Choose(node, SolverOf(&spec),
                  ", and {\"name\": …, \"elastic_net\": RATIO}");
  }
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name", "elastic_net"}, {}));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  MLE_ASSIGN_OR_RETURN(spec.options.elastic_net_ratio,
                       node.At("elastic_net")
                           .Number({.min = 0.0, .max = 1.0, .open_min = true}));
  spec.options.solver = LassoSolver::kElasticNet;
  if (campaign.settings.correction.lambdas(0) > 0.0) return absl::OkStatus();
  return node.Fault(
      "the elastic net needs λ above 0, but the first value of lambda_grid is "
      "0: give min, max and count");
}

absl::StatusOr<Method> ParseEstimator(const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  absl::StatusOr<Method> method = ParseMethod(name);
  if (method.ok()) return method;
  return Unknown(node, method.status().message());
}

absl::Status ParseAblations(const JsonNode& node, Campaign& campaign) {
  if (!node.Has("ablations")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At("ablations").Elements());
  campaign.ablations.clear();
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const std::string name, element.Text());
    MLE_RETURN_IF_ERROR(CheckNewName(element, name, names));
    const Ablation* const ablation = FindAblation(name);
    if (ablation == nullptr && name != "none") {
      std::string known = "none";
      for (const Ablation& one : Ablations()) {
        absl::StrAppend(&known, ", ", one.name);
      }
      return Unknown(element, absl::StrCat("choose from ", known));
    }
    campaign.ablations.push_back(ablation);
  }
  return absl::OkStatus();
}

// {0, step, …, max}, or `count` values from min to max, each the same factor
// above the one before.
absl::StatusOr<Eigen::VectorXd> ParseLambdaGrid(const JsonNode& node) {
  if (node.json().is_object() && node.Has("step")) {
    MLE_RETURN_IF_ERROR(node.CheckKeys({"max", "step"}, {}));
    MLE_ASSIGN_OR_RETURN(const double max, node.At("max").Number(kPositive));
    MLE_ASSIGN_OR_RETURN(const double step, node.At("step").Number(kPositive));
    return node.Check(MakeLambdaGrid(max, step));
  }
  MLE_RETURN_IF_ERROR(node.CheckKeys({"min", "max", "count"}, {}));
  MLE_ASSIGN_OR_RETURN(const double min, node.At("min").Number(kPositive));
  MLE_ASSIGN_OR_RETURN(const double max,
                       node.At("max").Number({.min = min, .open_min = true}));
  MLE_ASSIGN_OR_RETURN(const std::int64_t count,
                       node.At("count").Integer(2, 1'000'000));
  Eigen::VectorXd grid(count);
  for (std::int64_t i = 0; i < count; ++i) {
    grid(i) = min * std::pow(max / min, static_cast<double>(i) /
                                            static_cast<double>(count - 1));
  }
  grid(count - 1) = max;
  return grid;
}

// The lists that describe how is estimated, with their defaults, and the
// methods they make. Needs the grid of λ.
absl::Status ParseMethods(const JsonNode& node, Campaign& campaign) {
  MLE_RETURN_IF_ERROR(
      ReadNamedList(node, "selections", ParseSelection, campaign.selections));
  const auto parse_solver = [&campaign](const JsonNode& element,
                                        SolverSpec& spec) {
    return ParseSolver(element, campaign, spec);
  };
  MLE_RETURN_IF_ERROR(
      ReadNamedList(node, "solvers", parse_solver, campaign.solvers));
  MLE_RETURN_IF_ERROR(ParseAblations(node, campaign));
  if (!node.Has("estimators")) {
    AddMethods(PaperMethod(), campaign);
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At("estimators").Elements());
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const Method method, ParseEstimator(element));
    MLE_RETURN_IF_ERROR(CheckNewName(element, method.name(), names));
    AddMethods(method, campaign);
  }
  return absl::OkStatus();
}

absl::Status ParseSettings(const JsonNode& node, Campaign& campaign) {
  ExperimentOptions& settings = campaign.settings;
  MLE_RETURN_IF_ERROR(ReadOptions(node, OptionsOf(settings)));
  if (node.Has("conversion")) {
    MLE_RETURN_IF_ERROR(ReadOptionsOnly(node.At("conversion"), {},
                                        ConversionOptionsOf(settings)));
  }
  const ParsedJson paper_grid = {{"max", 1e-2}, {"step", 1e-6}};
  MLE_ASSIGN_OR_RETURN(
      settings.correction.lambdas,
      ParseLambdaGrid(node.Has("lambda_grid") ? node.At("lambda_grid")
                                              : JsonNode(paper_grid, "")));
  return ParseMethods(node, campaign);
}

}  // namespace

absl::Status CheckEffects(const JsonNode& effects, const JsonNode& campaign) {
  std::vector<ModelSpec> models;
  if (!campaign.Has("models") ||
      !ReadNamedList(campaign, "models", ParseModelSpec, models).ok()) {
    return absl::OkStatus();
  }
  return ParseEffectsOf(effects, models).status();
}

absl::StatusOr<Campaign> ParseCampaign(std::string_view resolved,
                                       const std::string& source) {
  MLE_ASSIGN_OR_RETURN(const ParsedJson json,
                       ParseStrictJson(resolved, source));
  const JsonNode node(json, source);
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {"version", "name", "seeds", "models", "mismatches"},
      {"noise_variances", "drift_variances", "effects", "controllers",
       "windows", "ablations", "estimators", "selections", "solvers",
       "sample_time", "order", "response_horizon", "lambda_grid", "scaling",
       "conversion"}));
  MLE_RETURN_IF_ERROR(node.At("version").Integer(1, 1).status());
  Campaign campaign;
  MLE_ASSIGN_OR_RETURN(campaign.name, node.At("name").Name());
  MLE_RETURN_IF_ERROR(ParseAxes(node, campaign));
  MLE_RETURN_IF_ERROR(ParseSettings(node, campaign));
  if (!Grid(campaign).IsCountable()) {
    return node.Fault("the grid has more than 1e9 runs; take fewer values");
  }
  const absl::Status scenarios = CheckScenarios(campaign);
  // The checks name flags of mle_reproduce; the keys are called the same.
  if (!scenarios.ok()) {
    return node.Fault(absl::StrReplaceAll(scenarios.message(), {{"--", ""}}));
  }
  return campaign;
}

}  // namespace mle::experiment
