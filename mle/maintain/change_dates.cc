#include "mle/maintain/change_dates.h"

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/record_clock.h"

namespace mle {

absl::Status AddChangeDates(const HistorianReport& report,
                            const ProcessModel& model, RecordOptions& options) {
  if (options.change_dates.empty()) return absl::OkStatus();
  std::vector<double>& times = options.windows.change_times;
  if (!report.time_origin) {
    return OptionError(
        "change_times",
        absl::StrCat("change_times has the date '", options.change_dates[0],
                     "', but the times of the records are numbers; name the "
                     "time in ",
                     model.time_unit()));
  }
  for (const std::string& date : options.change_dates) {
    // In the zone of the records, from their beginning.
    MLE_ASSIGN_OR_RETURN(RecordClock clock,
                         RecordClock::Create(model.time_unit(),
                                             {.time_zone = report.time_zone}));
    clock.set_origin(report.time_origin);
    double time = 0.0;
    if (!clock.Read(date, '.', time) || !clock.has_dates()) {
      return OptionError("change_times",
                         absl::StrCat("change_times: '", date, "' is not ",
                                      clock.Wanted(date)));
    }
    times.push_back(time);
  }
  std::sort(times.begin(), times.end());
  return absl::OkStatus();
}

}  // namespace mle
