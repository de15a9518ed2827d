// The part of the records that is read: times from `begin` to `end`, both
// included. Either is a number in the model's unit, a date (2024-02-29 12:34,
// or a day alone, which is its midnight), or empty: no limit.
//
//   MLE_ASSIGN_OR_RETURN(const TimeRange range,
//                        TimeRange::Create("2024-03-01", "", clock_options));
//   range.begin_seconds();   // 1709251200.0, in UTC
//
// Dates without a zone are in that of the records.

#ifndef MLE_DATA_TIME_RANGE_H_
#define MLE_DATA_TIME_RANGE_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record_clock.h"

namespace mle {

class TimeRange {
 public:
  // Everything.
  TimeRange() = default;
  // InvalidArgument, naming the option, for text that is neither a number nor a
  // date of a form that is certain, and for an end before the begin. `clock` is
  // that of the records.
  static absl::StatusOr<TimeRange> Create(const std::string& begin,
                                          const std::string& end,
                                          const ClockOptions& clock);

  bool is_everything() const { return !begin_.is_given && !end_.is_given; }
  // InvalidArgument for dates where the times that `clock` has read are
  // numbers, and the other way round.
  absl::Status Fits(const RecordClock& clock) const;
  // Whether the time that `clock` read last, `time` in the model's unit, is in
  // the range.
  bool Contains(double time, const RecordClock& clock) const;

  // Since 1970-01-01T00:00:00Z; nothing for numbers and where no limit is.
  std::optional<double> begin_seconds() const { return begin_.seconds; }
  std::optional<double> end_seconds() const { return end_.seconds; }
  // "from 2024-03-01 on", for messages; empty for everything.
  std::string Text() const;

 private:
  struct Limit {
    std::string text;
    bool is_given = false;
    double number = 0.0;            // in the model's unit
    std::optional<double> seconds;  // of a date
  };
  static absl::StatusOr<Limit> Read(const std::string& option,
                                    const std::string& text,
                                    const ClockOptions& clock);

  Limit begin_;
  Limit end_;
};

}  // namespace mle

#endif  // MLE_DATA_TIME_RANGE_H_
