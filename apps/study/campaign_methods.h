// The parts of a campaign's JSON that describe how is estimated.

#ifndef APPS_STUDY_CAMPAIGN_METHODS_H_
#define APPS_STUDY_CAMPAIGN_METHODS_H_

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/study/campaign.h"
#include "mle/model/json_node.h"

namespace mle::study {

// {0, step, …, max}, or `count` values from min to max, each the same factor
// above the one before.
absl::StatusOr<Eigen::VectorXd> ParseLambdaGrid(const JsonNode& node);

// The lists `selections`, `solvers`, `ablations` and `estimators` of the
// campaign's object, with their defaults, and the methods they make. Needs the
// grid of λ.
absl::Status ParseMethods(const JsonNode& campaign_node,
                          experiment::Campaign& campaign);

}  // namespace mle::study

#endif  // APPS_STUDY_CAMPAIGN_METHODS_H_
