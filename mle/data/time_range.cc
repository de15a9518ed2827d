#include "mle/data/time_range.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"

namespace mle {

absl::StatusOr<TimeRange::Limit> TimeRange::Read(const std::string& option,
                                                 const std::string& text,
                                                 const ClockOptions& clock) {
  Limit limit;
  limit.text = text;
  limit.is_given = !text.empty();
  if (!limit.is_given) return limit;
  if (ReadCsvNumber(text, limit.number) && std::isfinite(limit.number)) {
    return limit;
  }
  // The unit does not matter: the clock keeps seconds.
  for (const std::string& date : {text, absl::StrCat(text, " 00:00")}) {
    MLE_ASSIGN_OR_RETURN(
        RecordClock reader,
        RecordClock::Create("s", {.time_zone = clock.time_zone}));
    double ignored = 0.0;
    if (!reader.Read(date, '.', ignored) || !reader.has_dates()) continue;
    limit.seconds = reader.last_seconds();
    return limit;
  }
  return OptionError(
      option, absl::StrCat(option, ": '", ShowCsvText(text),
                           "' is not a number, nor a date such as 2024-02-29 "
                           "12:34"));
}

absl::StatusOr<TimeRange> TimeRange::Create(const std::string& begin,
                                            const std::string& end,
                                            const ClockOptions& clock) {
  TimeRange range;
  MLE_ASSIGN_OR_RETURN(range.begin_, Read("begin", begin, clock));
  MLE_ASSIGN_OR_RETURN(range.end_, Read("end", end, clock));
  if (!range.begin_.is_given || !range.end_.is_given) return range;
  const bool has_dates = range.begin_.seconds.has_value();
  if (has_dates != range.end_.seconds.has_value()) {
    return OptionError("begin,end",
                       absl::StrCat("begin is '", begin, "' and end is '", end,
                                    "'; both must be dates, or both numbers"));
  }
  if (has_dates ? *range.end_.seconds < *range.begin_.seconds
                : range.end_.number < range.begin_.number) {
    return OptionError(
        "begin,end", absl::StrCat("end is '", end, "', before begin, '", begin,
                                  "'; it must not be earlier"));
  }
  return range;
}

absl::Status TimeRange::Fits(const RecordClock& clock) const {
  const Limit& limit = begin_.is_given ? begin_ : end_;
  if (!limit.is_given || limit.seconds.has_value() == clock.has_dates()) {
    return absl::OkStatus();
  }
  const std::string option = begin_.is_given ? "begin" : "end";
  return OptionError(
      option,
      absl::StrCat(option, " is '", limit.text, "', ",
                   clock.has_dates()
                       ? "a number, but the times of the records are dates; "
                         "name a date such as 2024-02-29 12:34"
                       : "a date, but the times of the records are numbers; "
                         "name a number in the model's time unit"));
}

bool TimeRange::Contains(double time, const RecordClock& clock) const {
  if (is_everything()) return true;
  const bool has_dates = clock.has_dates();
  const double at = has_dates ? clock.last_seconds().value_or(0.0) : time;
  if (begin_.is_given && at < begin_.seconds.value_or(begin_.number)) {
    return false;
  }
  return !end_.is_given || at <= end_.seconds.value_or(end_.number);
}

std::string TimeRange::Text() const {
  if (is_everything()) return "";
  if (!end_.is_given) return absl::StrCat("from ", begin_.text, " on");
  if (!begin_.is_given) return absl::StrCat("up to ", end_.text);
  return absl::StrCat("from ", begin_.text, " to ", end_.text);
}

}  // namespace mle
