// Campaigns whose runs take a few hundredths of a second.

#ifndef TESTS_APPS_STUDY_SMALL_CAMPAIGN_H_
#define TESTS_APPS_STUDY_SMALL_CAMPAIGN_H_

#include <string>

#include "nlohmann/json.hpp"

namespace mle::study {

// Of one column of two outputs, model and plants being part of the text: gain
// and delay mismatches, `seeds` seeds from 1 on.
nlohmann::json SmallCampaign(int seeds);

}  // namespace mle::study

#endif  // TESTS_APPS_STUDY_SMALL_CAMPAIGN_H_
