// The time column of a record: numbers, or dates of one form, as times in the
// model's unit. Dates count from the first one.
//
// Dates without a zone are UTC, or the civil time of a declared zone: then the
// order of the rows distinguishes an hour that the clocks show twice.
//
//   MLE_ASSIGN_OR_RETURN(RecordClock clock, RecordClock::Create("min", {}));
//   clock.Read("2024-02-29T12:34:56Z", '.', time);
//   clock.Read("29-Feb-24 12:34:56.0", '.', time);

#ifndef MLE_DATA_RECORD_CLOCK_H_
#define MLE_DATA_RECORD_CLOCK_H_

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "mle/data/import_options.h"
#include "mle/data/time_format.h"

namespace mle {

class RecordClock {
 public:
  // InvalidArgument for units, zones and patterns that are not known.
  static absl::StatusOr<RecordClock> Create(const std::string& model_unit,
                                            const ClockOptions& options);

  // False for text that is not a time in the form of the first one.
  bool Read(std::string_view field, char decimal, double& time);
  // Describes the times that Read() takes, for a message about `field`, which
  // it did not take.
  std::string Wanted(std::string_view field) const;

  bool has_dates() const { return has_dates_; }
  // As declared or recognised.
  TimeFormat format() const { return form_.format; }
  const std::string& form_name() const { return form_.name; }
  // Times are numbers whose unit nobody declared.
  bool has_assumed_unit() const { return is_recognised_ && !has_number_unit_; }
  // Seconds since 1970-01-01T00:00:00Z of the first time, if that is a date.
  std::optional<double> origin() const { return origin_; }
  // The same of the last time.
  std::optional<double> last_seconds() const { return last_seconds_; }
  // Dates count from here instead. Before the first Read().
  void set_origin(std::optional<double> origin) { origin_ = origin; }
  // Rows are newest first.
  void set_descending(bool descending) { is_descending_ = descending; }
  // Seconds in the model's unit, where that is known.
  std::optional<double> seconds_per_unit() const { return seconds_per_unit_; }

 private:
  RecordClock() = default;

  void Recognise(std::string_view text, char decimal);
  bool ReadNumber(std::string_view text, char decimal, double& time);
  bool ReadDate(std::string_view text, double& time);
  bool SetTime(double seconds, double& time);
  std::optional<CivilTime> ReadCivil(std::string_view text);
  // Seconds since the epoch; nothing for a time that the zone skips.
  std::optional<double> InZone(const CivilTime& civil);

  TimeForm form_;
  std::size_t pattern_ = 0;  // of the last date
  std::string model_unit_;
  std::optional<double> seconds_per_unit_;  // of the model
  double number_scale_ = 1.0;               // to the model's unit
  bool has_number_unit_ = false;
  std::optional<absl::TimeZone> zone_;
  std::string zone_name_;
  bool is_descending_ = false;

  bool is_first_ = true;
  bool is_recognised_ = false;
  bool has_dates_ = false;
  std::optional<double> origin_;
  std::optional<double> last_seconds_;
};

}  // namespace mle

#endif  // MLE_DATA_RECORD_CLOCK_H_
