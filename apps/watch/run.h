// A run of mle_watch over all controllers.

#ifndef APPS_WATCH_RUN_H_
#define APPS_WATCH_RUN_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/watch/health.h"
#include "apps/watch/request.h"
#include "apps/watch/state.h"

namespace mle::watch {

struct RunSummary {
  int controllers = 0;
  int aged = 0;
  // Sentences on all failures: a controller that could not be looked at, a
  // wrong list of controllers, an alarm that was not accepted.
  std::vector<std::string> failures = {};
};

// Brings the state up to date, hands on alarms and writes the pages. A
// controller whose records or model are broken stops no other. Errors are of
// the state and the folder. Unavailable where another run is at work.
absl::StatusOr<RunSummary> RunWatches(const Request& request);

// Does what --serve asks for: serves until SIGINT, SIGTERM or SIGHUP; then
// answers the requests that have come and returns. Errors are about the state,
// the list of controllers, the token and the address.
absl::Status ServeSite(const Request& request);

// Does what --acknowledge asks for; says on standard output what was done.
absl::Status AcknowledgeAlarm(const Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_RUN_H_
