// Ticks of an axis whose values stand for dates: at whole seconds, minutes,
// hours, days, months or years of a zone.
//
//   DateTicks({0.0, 1200.0}, {.origin = 1709532000.0, .seconds_per_unit = 60.0,
//                             .zone = absl::UTCTimeZone()}, 5);
//   // 08:00, 12:00, 16:00, 20:00, "5 Mar" at midnight

#ifndef APPS_REPORT_DATE_TICKS_H_
#define APPS_REPORT_DATE_TICKS_H_

#include <vector>

#include "apps/report/axis.h"
#include "apps/report/figure.h"

namespace mle::report {

// At most `wanted` (≥ 2) and one of them within `range`, all labelled; where
// the range has no two whole seconds, as on an axis without dates.
std::vector<Tick> DateTicks(const Range& range, const DateScale& dates,
                            int wanted);

}  // namespace mle::report

#endif  // APPS_REPORT_DATE_TICKS_H_
