#include "apps/experiment/campaign_json.h"

#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "apps/common/option_json.h"
#include "apps/experiment/grid.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/correction/correction.h"
#include "mle/exchange/model_file.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::experiment {
namespace {

using ParsedJson = nlohmann::json;

absl::StatusOr<ParsedJson> ReadModelJson(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const ModelFile file, ReadModelFile(path));
  return ParsedJson::parse(FormatProcessModel(file.process));
}

// The effects of a file. Keys and channels must be right for all models of the
// campaign, if these are.
absl::StatusOr<ParsedJson> ReadEffectsFile(const std::string& path,
                                           const JsonNode& campaign) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  MLE_ASSIGN_OR_RETURN(ParsedJson json, ParseStrictJson(text, path));
  if (!campaign.Has("models")) return json;
  std::vector<ModelSpec> models;
  if (!ReadNamedList(campaign, "models", ParseModelSpec, models).ok()) {
    return json;
  }
  MLE_RETURN_IF_ERROR(ParseEffectsOf(JsonNode(json, path), models).status());
  return json;
}

using FileReader =
    std::function<absl::StatusOr<ParsedJson>(const std::string&)>;

// Replaces the file that `key` of `entry` names by what it holds, under
// `new_key`. What stands there itself is left.
absl::Status ReadIn(const JsonNode& node, const std::string& key,
                    const std::string& new_key, const std::string& folder,
                    const FileReader& read, ParsedJson& entry) {
  MLE_ASSIGN_OR_RETURN(std::string path, node.At(key).Text());
  const bool relative = path.rfind('/', 0) != 0;
  if (relative && !folder.empty()) path = absl::StrCat(folder, "/", path);
  MLE_ASSIGN_OR_RETURN(ParsedJson content, node.At(key).Check(read(path)));
  entry.erase(key);
  entry[new_key] = std::move(content);
  return absl::OkStatus();
}

// For every entry of a list that is an object with a string at `key`. What is
// no list is left for ParseCampaign() to refuse.
absl::Status ReadInList(const JsonNode& campaign, const std::string& list,
                        const std::string& key, const std::string& new_key,
                        const std::string& folder, const FileReader& read,
                        ParsedJson& resolved) {
  if (!campaign.Has(list) || !campaign.At(list).json().is_array() ||
      campaign.At(list).json().empty()) {
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> entries,
                       campaign.At(list).Elements());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!entries[i].json().is_object() || !entries[i].Has(key)) continue;
    if (key == new_key && !entries[i].At(key).json().is_string()) continue;
    if (key != new_key && entries[i].Has(new_key)) {
      return entries[i].Fault("has ", key, " and ", new_key,
                              "; only one is possible");
    }
    MLE_RETURN_IF_ERROR(
        ReadIn(entries[i], key, new_key, folder, read, resolved[list][i]));
  }
  return absl::OkStatus();
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

absl::StatusOr<std::string> ResolveCampaign(std::string_view text,
                                            const std::string& source,
                                            const std::string& folder) {
  MLE_ASSIGN_OR_RETURN(const ParsedJson json, ParseStrictJson(text, source));
  const JsonNode node(json, source);
  if (!json.is_object()) {
    return node.Fault("must be an object, is ", node.Found());
  }
  ParsedJson resolved = json;
  MLE_RETURN_IF_ERROR(ReadInList(node, "models", "file", "model", folder,
                                 ReadModelJson, resolved));
  MLE_RETURN_IF_ERROR(ReadInList(node, "mismatches", "plant", "plant", folder,
                                 ReadModelJson, resolved));
  const auto read_effects = [&](const std::string& path) {
    return ReadEffectsFile(path, JsonNode(resolved, source));
  };
  MLE_RETURN_IF_ERROR(ReadInList(node, "effects", "file", "effects", folder,
                                 read_effects, resolved));
  return absl::StrCat(resolved.dump(2), "\n");
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
