// A map of the saving of policies by rates of ageing.

#ifndef APPS_LIFECYCLE_SAVING_MAP_H_
#define APPS_LIFECYCLE_SAVING_MAP_H_

#include <string>
#include <vector>

#include "apps/lifecycle/summary.h"
#include "apps/report/drawing.h"

namespace mle::lifecycle {

// A square for each policy and rate: what is saved a year against never, with
// the half-width of its interval of 95 %. The larger a part of the largest mean
// saving at that rate, the darker; a saving within its interval of zero is
// white. `summaries`: by rising rate, all of the same policies, `never` among
// them and others too.
report::NamedFigure SavingMap(const std::vector<const RateSummary*>& summaries,
                              const std::string& currency);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_SAVING_MAP_H_
