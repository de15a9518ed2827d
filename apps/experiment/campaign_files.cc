#include <functional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/experiment/campaign_json.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/exchange/model_file.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::experiment {
namespace {

using ParsedJson = nlohmann::json;

absl::StatusOr<ParsedJson> ReadModelJson(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const ModelFile file, ReadModelFile(path));
  if (HasTransforms(file.process)) {
    return absl::InvalidArgumentError(absl::StrCat(
        path,
        ": has transforms; campaigns have linear models and plants "
        "(mle_convert --at makes them)"));
  }
  return ParsedJson::parse(FormatProcessModel(file.process));
}

absl::StatusOr<ParsedJson> ReadEffectsFile(const std::string& path,
                                           const JsonNode& campaign) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  MLE_ASSIGN_OR_RETURN(ParsedJson json, ParseStrictJson(text, path));
  MLE_RETURN_IF_ERROR(CheckEffects(JsonNode(json, path), campaign));
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

}  // namespace mle::experiment
