// The flags of mle_lifecycle, as a campaign of lives and its prices.
// `mle_lifecycle --help` lists them.

#ifndef APPS_LIFECYCLE_FLAGS_H_
#define APPS_LIFECYCLE_FLAGS_H_

#include "absl/status/statusor.h"
#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/prices.h"

namespace mle::lifecycle {

struct Request {
  Campaign campaign;
  Prices prices;
  double hours_per_unit = 1.0;
  double years = 5.0;
  bool figures = true;
};

// Reads the files and checks everything that can be checked before something is
// simulated; errors name the flag or the file.
absl::StatusOr<Request> RequestFromFlags();

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_FLAGS_H_
