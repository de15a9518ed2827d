// The routes of the watch's server (docs/watch.md):
//
//   GET  /, /alarms.html, /controller-ID.html    the pages
//   GET  /proposals/ID/DAY/FILE                  of corrections
//   GET  /watch.json, /metrics
//   GET  /api/v1/controllers[?status=…&search=…]
//   GET  /api/v1/controllers/ID
//   GET  /api/v1/controllers/ID/history[?from=DAY&to=DAY]
//   GET  /api/v1/alarms[?open=true]
//   POST /api/v1/alarms/ID/acknowledgement       {"who": …, "note": …}
//   POST /acknowledge                            the same from a page's form

#ifndef APPS_WATCH_ROUTES_H_
#define APPS_WATCH_ROUTES_H_

#include "apps/serve/access.h"
#include "apps/serve/server.h"
#include "apps/watch/site.h"

namespace mle::watch {

// Called by many threads at once.
serve::Response Answer(Site& site, const serve::Access& access,
                       const serve::Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_ROUTES_H_
