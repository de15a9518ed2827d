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
  // What could not be done, in words: of a controller that could not be looked
  // at, of an alarm that was not taken.
  std::vector<std::string> failures = {};
};

// Brings the state up to date, hands on alarms and writes the pages. A
// controller whose records or model are broken stops no other. Errors are of
// the state and the folder. Unavailable where another run is at work.
absl::StatusOr<RunSummary> RunWatches(const Request& request);

// What --serve asks for: serves until SIGINT, SIGTERM or SIGHUP; then answers
// what was asked and returns. Errors are of the state, the list of controllers,
// the token and the address.
absl::Status ServeSite(const Request& request);

// What --acknowledge asks for; says on standard output what was done.
absl::Status AcknowledgeAlarm(const Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_RUN_H_
