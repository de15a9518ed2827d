// What is shown of reports: pages, JSON and metrics.

#ifndef APPS_WATCH_REPORT_H_
#define APPS_WATCH_REPORT_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "apps/report/figure.h"
#include "apps/report/html.h"
#include "apps/watch/health.h"
#include "apps/watch/state.h"

namespace mle::watch {

// The pages of the watch.

// Words that the pages of the watch share.

// The explanation of health values.
extern const char* const kMeaning;

std::string LastDayOf(const Report& report);
report::Axis DayAxis();
std::string HealthText(const Report& report);

// "2026-02-10 09:30 UTC", of seconds since 1970.
std::string TimeText(std::int64_t seconds);

// "by Ann at 2026-02-10 09:30 UTC: valve ordered", or "not yet".
std::string AcknowledgementText(const Alarm& alarm);
// "command, webhook not yet (3 attempts): it answered with status 500".
std::string DeliveryText(const Alarm& alarm);
// Enough for mle_watch --acknowledge.
std::string ShortId(const Alarm& alarm);

// "1 alarm", "2 alarms".
std::string Counted(int count, std::string_view what);

// All controllers; in each row a link to the controller's page. `fault`: why
// the state could not be read since.
std::string FormatOverview(const std::vector<Report>& reports,
                           const std::string& fault = "");

// The alarms of all controllers, the last ones first.
std::string FormatAlarmsPage(const std::vector<Report>& reports);

// One controller: health of each element, trend, alarms, proposals, days that
// could not be used. `folder` is that of the page. `can_acknowledge`: with a
// form for each alarm, of use where a server takes it.
std::string FormatControllerPage(const Report& report,
                                 const std::string& folder,
                                 bool can_acknowledge = false);

// On its page: health of the outputs over dates, what it says of a trend in
// words, and, of an output whose element is known, by how much its parameter
// has changed. Nothing without days.
void AddTrend(const Report& report, report::HtmlPage& page);

// The names of the files, and where the forms lead.
inline constexpr char kOverviewPage[] = "index.html";
inline constexpr char kAlarmsPage[] = "alarms.html";
inline constexpr char kAcknowledgePath[] = "/acknowledge";
std::string PageName(const Report& report);

// The results of the watch for programs: watch.json, and the answers of the
// server (docs/watch.md).

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

// The state of all watches for Prometheus (text format 0.0.4).

// `read_at`: when the state was read, s since 1970; `fault`: why it could not
// be read since.
std::string FormatMetrics(const std::vector<Report>& reports,
                          std::int64_t read_at, const std::string& fault = "");

// As the value of a label: UTF-8, with \\, \" and \n.
std::string EscapeLabel(std::string_view text);

}  // namespace mle::watch

#endif  // APPS_WATCH_REPORT_H_
