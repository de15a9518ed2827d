// What a life costs at given prices (control/operating_cost.h).

#ifndef APPS_LIFECYCLE_PRICES_H_
#define APPS_LIFECYCLE_PRICES_H_

#include "apps/lifecycle/life.h"
#include "control/operating_cost.h"

namespace mle::lifecycle {

// Product made during a step test counts with the rest. Corrections that found
// no change cost no engineer.
control::Cost CostOf(const ChangeRow& row, const control::Prices& prices,
                     double hours_per_unit);
control::Cost CostOf(const Life& life, const control::Prices& prices,
                     double hours_per_unit);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_PRICES_H_
