// The results of the watch for programs: watch.json, and the answers of the
// server (docs/watch.md).

#ifndef APPS_WATCH_REPORT_JSON_H_
#define APPS_WATCH_REPORT_JSON_H_

#include <string>
#include <vector>

#include "apps/watch/health.h"

namespace mle::watch {

// watch.json.
std::string FormatReports(const std::vector<Report>& reports);

// A list with one line for each controller.
std::string FormatControllers(const std::vector<Report>& reports);
// One controller, as in watch.json.
std::string FormatController(const Report& report);
// The health of its outputs at the ends of the days from one to another.
std::string FormatHistory(const Report& report, int from, int to);
// The alarms of all controllers: only those not acknowledged, or all.
std::string FormatAlarms(const std::vector<Report>& reports, bool only_open);

}  // namespace mle::watch

#endif  // APPS_WATCH_REPORT_JSON_H_
