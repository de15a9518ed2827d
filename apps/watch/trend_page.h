// The part of a controller's page that says how it goes on over months.

#ifndef APPS_WATCH_TREND_PAGE_H_
#define APPS_WATCH_TREND_PAGE_H_

#include "apps/report/html.h"
#include "apps/watch/health.h"

namespace mle::watch {

// Health of the outputs over dates, what it says of a trend in words, and, of
// an output whose element is known, by how much its parameter has changed.
// Nothing without days.
void AddTrend(const Report& report, report::HtmlPage& page);

}  // namespace mle::watch

#endif  // APPS_WATCH_TREND_PAGE_H_
