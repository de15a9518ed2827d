// Short names of what is compared: only what differs within the campaign.

#ifndef APPS_STUDY_LABELS_H_
#define APPS_STUDY_LABELS_H_

#include <string>

#include "apps/experiment/grid.h"
#include "apps/study/campaign.h"

namespace mle::study {

// "gain, noise 0.001"; the campaign's mismatch where nothing else differs.
std::string ScenarioLabel(const experiment::Campaign& campaign,
                          const experiment::Scenario& scenario);
// The same without the one axis that a figure has.
enum class Axis { kNone, kNoise, kDrift, kSize, kWindows, kController };
std::string ScenarioLabel(const experiment::Campaign& campaign,
                          const experiment::Scenario& scenario, Axis without);
// "arx, paper".
std::string MethodLabel(const experiment::Campaign& campaign,
                        const experiment::Method& method);

}  // namespace mle::study

#endif  // APPS_STUDY_LABELS_H_
