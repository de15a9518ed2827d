// A campaign (apps/experiment/campaign.h) from its JSON (docs/formats.md).

#ifndef APPS_EXPERIMENT_CAMPAIGN_JSON_H_
#define APPS_EXPERIMENT_CAMPAIGN_JSON_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
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

// That the effects of a file have the keys and channels that every model of the
// campaign needs, if its models are right.
absl::Status CheckEffects(const JsonNode& effects, const JsonNode& campaign);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_CAMPAIGN_JSON_H_
