// Campaigns whose runs take a few hundredths of a second.

#ifndef TESTS_APPS_EXPERIMENT_SMALL_CAMPAIGN_H_
#define TESTS_APPS_EXPERIMENT_SMALL_CAMPAIGN_H_

#include <string>

#include "nlohmann/json.hpp"

namespace mle::experiment {

// Of one column of two outputs, model and plants being part of the text: gain
// and delay mismatches, `seeds` seeds from 1 on.
nlohmann::json SmallCampaign(int seeds);

}  // namespace mle::experiment

#endif  // TESTS_APPS_EXPERIMENT_SMALL_CAMPAIGN_H_
