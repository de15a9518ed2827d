#include "mle/maintain/dates.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/record_clock.h"

namespace mle {

absl::Status AddDates(std::string_view option,
                      const std::vector<std::string>& dates,
                      const HistorianReport& report, const ProcessModel& model,
                      std::vector<double>& times) {
  if (dates.empty()) return absl::OkStatus();
  const std::string name(option);
  if (!report.time_origin) {
    return OptionError(
        option, absl::StrCat(name, " has the date '", dates[0],
                             "', but the times of the records are numbers; "
                             "name the time in ",
                             model.time_unit()));
  }
  for (const std::string& date : dates) {
    // In the zone of the records, from their beginning.
    MLE_ASSIGN_OR_RETURN(RecordClock clock,
                         RecordClock::Create(model.time_unit(),
                                             {.time_zone = report.time_zone}));
    clock.set_origin(report.time_origin);
    double time = 0.0;
    if (!clock.Read(date, '.', time) || !clock.has_dates()) {
      return OptionError(option, absl::StrCat(name, ": '", date, "' is not ",
                                              clock.Wanted(date)));
    }
    times.push_back(time);
  }
  std::sort(times.begin(), times.end());
  return absl::OkStatus();
}

}  // namespace mle
