// Policies in the words of those who run a plant.

#ifndef APPS_LIFECYCLE_POLICY_WORDS_H_
#define APPS_LIFECYCLE_POLICY_WORDS_H_

#include <string>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/policy.h"

namespace mle::lifecycle {

// In tables and figures: "corrected every 3rd change".
std::string ShortName(const Policy& policy);

// As an instruction: "Correct the model after every 3rd set-point change".
std::string Instruction(const Policy& policy);

// What it does and when, in sentences. `hours_per_unit`: of the model's time.
std::string Description(const Policy& policy, const Campaign& campaign,
                        double hours_per_unit);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_POLICY_WORDS_H_
