// How times of a record are written: as dates where the record has dates, else
// as numbers in the model's unit.
//
//   const TimeNames times = import.report.Times(model.time_unit());
//   times.At(53.0);           // "2024-03-04 06:53", or "53 min"
//   times.Span(53.0, 170.5);  // "2024-03-04 06:53 to 2024-03-04 08:50:30"

#ifndef MLE_DATA_TIME_NAMES_H_
#define MLE_DATA_TIME_NAMES_H_

#include <optional>
#include <string>

#include "absl/time/time.h"

namespace mle {

class TimeNames {
 public:
  // Numbers, without a unit.
  TimeNames() = default;
  // With `origin` (seconds since 1970-01-01T00:00:00Z at time 0) dates, in the
  // IANA zone; UTC where that is empty or not known. `unit` as in the model: a
  // unit that is not of time leaves numbers.
  TimeNames(const std::string& unit, std::optional<double> origin,
            const std::string& zone = "");

  bool has_dates() const { return origin_.has_value(); }
  // To the minute, with seconds where those are not 0.
  std::string At(double time) const;
  std::string Span(double from, double to) const;
  // Without the unit.
  std::string Short(double time) const;
  // 2024-03-04T06:53:00+00:00; nothing without dates.
  std::optional<std::string> Iso(double time) const;
  // "min", "UTC", "Europe/Berlin": what Short() leaves out.
  std::string unit() const { return has_dates() ? zone_.name() : unit_; }

 private:
  absl::Time TimeOf(double time) const;

  std::string unit_;
  std::optional<double> origin_;
  double seconds_per_unit_ = 1.0;
  absl::TimeZone zone_ = absl::UTCTimeZone();
};

}  // namespace mle

#endif  // MLE_DATA_TIME_NAMES_H_
