// A campaign (apps/experiment/campaign.h) from its JSON (docs/formats.md).

#ifndef APPS_EXPERIMENT_CAMPAIGN_JSON_H_
#define APPS_EXPERIMENT_CAMPAIGN_JSON_H_

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "mle/base/status.h"
#include "mle/model/json_node.h"

namespace mle::experiment {

// The campaign's text with every file it names read in: it needs no other file
// from here on, and its SHA-256 stands for all of them. `source` names the file
// in errors; relative names start in `folder`.
absl::StatusOr<std::string> ResolveCampaign(std::string_view text,
                                            const std::string& source,
                                            const std::string& folder);

// Parses the text that ResolveCampaign() gave. Everything that can be known
// before a run is checked; errors name the JSON path.
absl::StatusOr<Campaign> ParseCampaign(std::string_view resolved,
                                       const std::string& source);

// The parts of a campaign's JSON, for campaign_json.cc.

// Fails if `name` is in `names` already, which it joins.
absl::Status CheckNewName(const JsonNode& node, const std::string& name,
                          std::set<std::string>& names);

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
                                                    const NumberRange& range);

// Parsers of the parts that define the simulation.

absl::StatusOr<std::vector<std::uint64_t>> ParseSeeds(const JsonNode& node);
absl::Status ParseModelSpec(const JsonNode& node, ModelSpec& spec);
// Those that name a plant must have the channels of every model.
absl::StatusOr<std::vector<Mismatch>> ParseMismatches(
    const JsonNode& node, const std::vector<ModelSpec>& models);
// Effects as in a file of mle_simulate, for the channels of every model.
absl::StatusOr<std::vector<sim::Effects>> ParseEffectsOf(
    const JsonNode& node, const std::vector<ModelSpec>& models);
absl::Status ParseEffectsSpec(const JsonNode& node,
                              const std::vector<ModelSpec>& models,
                              EffectsSpec& spec);
absl::Status ParseController(const JsonNode& node, ControllerSpec& spec);
absl::Status ParseWindow(const JsonNode& node, WindowSpec& spec);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_CAMPAIGN_JSON_H_
