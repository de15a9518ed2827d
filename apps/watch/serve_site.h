// mle_watch --serve.

#ifndef APPS_WATCH_SERVE_SITE_H_
#define APPS_WATCH_SERVE_SITE_H_

#include "absl/status/status.h"
#include "apps/watch/request.h"

namespace mle::watch {

// Serves until SIGINT, SIGTERM or SIGHUP; then answers what was asked and
// returns. Errors are of the state, the list of controllers, the token and the
// address.
absl::Status ServeSite(const Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_SERVE_SITE_H_
