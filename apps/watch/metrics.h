// The state of all watches for Prometheus (text format 0.0.4).

#ifndef APPS_WATCH_METRICS_H_
#define APPS_WATCH_METRICS_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "apps/watch/health.h"

namespace mle::watch {

// `read_at`: when the state was read, s since 1970; `fault`: why it could not
// be read since.
std::string FormatMetrics(const std::vector<Report>& reports,
                          std::int64_t read_at, const std::string& fault = "");

// As the value of a label: UTF-8, with \\, \" and \n.
std::string EscapeLabel(std::string_view text);

}  // namespace mle::watch

#endif  // APPS_WATCH_METRICS_H_
