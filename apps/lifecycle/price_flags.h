// The flags of mle_lifecycle for prices: they change what a life costs, not how
// it goes.

#ifndef APPS_LIFECYCLE_PRICE_FLAGS_H_
#define APPS_LIFECYCLE_PRICE_FLAGS_H_

#include "absl/status/statusor.h"
#include "apps/lifecycle/prices.h"
#include "mle/model/process_model.h"

namespace mle::lifecycle {

absl::StatusOr<Prices> PricesFromFlags(const ProcessModel& model);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_PRICE_FLAGS_H_
