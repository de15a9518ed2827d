// The pages of the watch, and watch.json, which says the same to programs.

#ifndef APPS_WATCH_PAGE_H_
#define APPS_WATCH_PAGE_H_

#include <string>
#include <vector>

#include "apps/watch/health.h"

namespace mle::watch {

// All controllers; in each row a link to the controller's page.
std::string FormatOverview(const std::vector<Report>& reports);

// One controller: health of each element, trend, alarms, proposals, days that
// could not be used. `folder` is that of the page.
std::string FormatControllerPage(const Report& report,
                                 const std::string& folder);

// The name of its file.
std::string PageName(const Report& report);

std::string FormatReports(const std::vector<Report>& reports);

}  // namespace mle::watch

#endif  // APPS_WATCH_PAGE_H_
