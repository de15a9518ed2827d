// The time column of a record: numbers, or dates of one form, as times in the
// model's unit. Dates count from the first one.
//
// Dates without a zone are UTC, or the civil time of a declared zone: then the
// order of the rows distinguishes an hour that the clocks show twice.
//
//   MLE_ASSIGN_OR_RETURN(RecordClock clock, RecordClock::Create("min", {}));
//   clock.Read("2024-02-29T12:34:56Z", '.', time);

#ifndef MLE_DATA_RECORD_CLOCK_H_
#define MLE_DATA_RECORD_CLOCK_H_

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace mle {

enum class TimeFormat {
  kRecognise,   // numbers or ISO 8601, as the first row has it
  kNumbers,     // in ClockOptions::number_unit
  kIso,         // 2024-02-29T12:34:56Z, with another zone or none
  kDayFirst,    // 29.02.2024 12:34:56, 29/2/2024 12:34
  kMonthFirst,  // 2/29/2024 12:34:56 PM
};

struct ClockOptions {
  TimeFormat format = TimeFormat::kRecognise;
  // Unit of times that are numbers: ms, s, min, h, d; empty: the model's.
  std::string number_unit = {};
  // Of dates without a zone, as the IANA names it ("Europe/Berlin"); empty:
  // UTC, or local time that has no change of clocks in it.
  std::string time_zone = {};
};

class RecordClock {
 public:
  // InvalidArgument for units and zones that are not known.
  static absl::StatusOr<RecordClock> Create(const std::string& model_unit,
                                            const ClockOptions& options);

  // False for text that is not a time in the form of the first one.
  bool Read(std::string_view field, char decimal, double& time);
  // What Read() takes, for a message.
  std::string Wanted() const;

  bool has_dates() const { return has_dates_; }
  // Seconds since 1970-01-01T00:00:00Z of the first time, if that is a date.
  std::optional<double> origin() const { return origin_; }
  // Dates count from here instead. Before the first Read().
  void set_origin(std::optional<double> origin) { origin_ = origin; }
  // An hour, where the model's unit is known.
  std::optional<double> hour() const;

 private:
  RecordClock() = default;

  bool ReadDate(std::string_view text, double& time);
  // Seconds since the epoch; nothing for a time that the zone skips.
  std::optional<double> InZone(std::string_view text);

  TimeFormat format_ = TimeFormat::kRecognise;
  std::string model_unit_;
  std::optional<double> seconds_per_unit_;  // of the model
  double number_scale_ = 1.0;               // to the model's unit
  std::optional<absl::TimeZone> zone_;
  std::string zone_name_;

  bool is_first_ = true;
  bool has_dates_ = false;
  std::optional<double> origin_;
  double last_seconds_ = -1e300;
};

}  // namespace mle

#endif  // MLE_DATA_RECORD_CLOCK_H_
