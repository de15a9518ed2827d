#include "apps/study/campaign.h"

#include <functional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/common/option_json.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/experiment_options.h"
#include "apps/experiment/grid.h"
#include "apps/study/campaign_json.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/exchange/model_file.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::study {
namespace {

using experiment::Campaign;
using experiment::CheckScenarios;
using experiment::ExperimentOptions;
using experiment::Grid;

using ParsedJson = nlohmann::json;

absl::StatusOr<ParsedJson> ReadModelJson(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const ModelFile file, ReadModelFile(path));
  return ParsedJson::parse(FormatProcessModel(file.process));
}

// Whose keys and channels must be right for all models of the campaign, if
// these are.
absl::StatusOr<ParsedJson> ReadEffectsFile(const std::string& path,
                                           const JsonNode& campaign) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  MLE_ASSIGN_OR_RETURN(ParsedJson json, ParseStrictJson(text, path));
  if (!campaign.Has("models")) return json;
  const auto models = ParseModels(campaign.At("models"));
  if (!models.ok()) return json;
  MLE_RETURN_IF_ERROR(ParseEffectsOf(JsonNode(json, path), *models).status());
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
  absl::StatusOr<ParsedJson> content = read(path);
  if (!content.ok()) {
    return node.At(key).Fault(std::string(content.status().message()));
  }
  entry.erase(key);
  entry[new_key] = *std::move(content);
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
      return entries[i].Fault(absl::StrCat("has ", key, " and ", new_key,
                                           "; only one is possible"));
    }
    MLE_RETURN_IF_ERROR(
        ReadIn(entries[i], key, new_key, folder, read, resolved[list][i]));
  }
  return absl::OkStatus();
}

absl::Status ParseAxes(const JsonNode& node, Campaign& campaign) {
  MLE_ASSIGN_OR_RETURN(campaign.seeds, ParseSeeds(node.At("seeds")));
  MLE_ASSIGN_OR_RETURN(campaign.models, ParseModels(node.At("models")));
  MLE_ASSIGN_OR_RETURN(campaign.mismatches,
                       ParseMismatches(node.At("mismatches"), campaign.models));
  if (node.Has("noise_variances")) {
    MLE_ASSIGN_OR_RETURN(
        campaign.noise_variances,
        ParseNumberList(node.At("noise_variances"), kNotNegative));
  }
  if (node.Has("drift_variances")) {
    MLE_ASSIGN_OR_RETURN(
        campaign.drift_variances,
        ParseNumberList(node.At("drift_variances"), kNotNegative));
  }
  if (node.Has("effects")) {
    MLE_ASSIGN_OR_RETURN(campaign.effects,
                         ParseEffectsAxis(node.At("effects"), campaign.models));
  }
  if (node.Has("controllers")) {
    MLE_ASSIGN_OR_RETURN(campaign.controllers,
                         ParseControllers(node.At("controllers")));
  }
  if (node.Has("windows")) {
    MLE_ASSIGN_OR_RETURN(campaign.windows, ParseWindows(node.At("windows")));
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
    return node.Fault(absl::StrCat("must be an object, is ", node.Found()));
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

}  // namespace mle::study
