// The parts of a campaign's JSON, for campaign.cc.

#ifndef APPS_STUDY_CAMPAIGN_JSON_H_
#define APPS_STUDY_CAMPAIGN_JSON_H_

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/study/campaign.h"
#include "mle/model/json_node.h"

namespace mle::study {

// The parts of a campaign's JSON that describe what is simulated.

absl::StatusOr<std::vector<std::uint64_t>> ParseSeeds(const JsonNode& node);
absl::StatusOr<std::vector<experiment::ModelSpec>> ParseModels(
    const JsonNode& node);
// Those that name a plant must have the channels of every model.
absl::StatusOr<std::vector<experiment::Mismatch>> ParseMismatches(
    const JsonNode& node, const std::vector<experiment::ModelSpec>& models);
// Effects as in a file of mle_simulate, for the channels of every model.
absl::StatusOr<std::vector<sim::Effects>> ParseEffectsOf(
    const JsonNode& node, const std::vector<experiment::ModelSpec>& models);
absl::StatusOr<std::vector<experiment::EffectsSpec>> ParseEffectsAxis(
    const JsonNode& node, const std::vector<experiment::ModelSpec>& models);
absl::StatusOr<std::vector<experiment::ControllerSpec>> ParseControllers(
    const JsonNode& node);
absl::StatusOr<std::vector<experiment::WindowSpec>> ParseWindows(
    const JsonNode& node);
// A list of different numbers.
absl::StatusOr<std::vector<double>> ParseNumberList(const JsonNode& node,
                                                    const NumberRange& range);

// Fails if `name` is in `names` already, which it joins.
absl::Status CheckNewName(const JsonNode& node, const std::string& name,
                          std::set<std::string>& names);

// The parts of a campaign's JSON that describe how is estimated.

// {0, step, …, max}, or `count` values from min to max, each the same factor
// above the one before.
absl::StatusOr<Eigen::VectorXd> ParseLambdaGrid(const JsonNode& node);

// The lists `selections`, `solvers`, `ablations` and `estimators` of the
// campaign's object, with their defaults, and the methods they make. Needs the
// grid of λ.
absl::Status ParseMethods(const JsonNode& campaign_node,
                          experiment::Campaign& campaign);

}  // namespace mle::study

#endif  // APPS_STUDY_CAMPAIGN_JSON_H_
