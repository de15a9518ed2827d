// The pages of the watch.

#ifndef APPS_WATCH_PAGE_H_
#define APPS_WATCH_PAGE_H_

#include <string>
#include <vector>

#include "apps/watch/health.h"

namespace mle::watch {

// All controllers; in each row a link to the controller's page.
std::string FormatOverview(const std::vector<Report>& reports);

// The alarms of all controllers, the last ones first.
std::string FormatAlarmsPage(const std::vector<Report>& reports);

// One controller: health of each element, trend, alarms, proposals, days that
// could not be used. `folder` is that of the page. `can_acknowledge`: with a
// form for each alarm, of use where a server takes it.
std::string FormatControllerPage(const Report& report,
                                 const std::string& folder,
                                 bool can_acknowledge = false);

// The names of the files, and where the forms lead.
inline constexpr char kOverviewPage[] = "index.html";
inline constexpr char kAlarmsPage[] = "alarms.html";
inline constexpr char kAcknowledgePath[] = "/acknowledge";
std::string PageName(const Report& report);

}  // namespace mle::watch

#endif  // APPS_WATCH_PAGE_H_
