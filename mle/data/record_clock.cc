#include "mle/data/record_clock.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/time/civil_time.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/iso_time.h"

namespace mle {
namespace {

DateOrder OrderOf(TimeFormat format) {
  if (format == TimeFormat::kDayFirst) return DateOrder::kDayFirst;
  if (format == TimeFormat::kMonthFirst) return DateOrder::kMonthFirst;
  return DateOrder::kYearFirst;
}

double Seconds(absl::Time time) {
  return absl::ToDoubleSeconds(time - absl::UnixEpoch());
}

}  // namespace

absl::StatusOr<RecordClock> RecordClock::Create(const std::string& model_unit,
                                                const ClockOptions& options) {
  RecordClock clock;
  clock.format_ = options.format;
  clock.model_unit_ = model_unit;
  clock.seconds_per_unit_ = SecondsPerUnit(model_unit);
  if (!options.number_unit.empty() && options.number_unit != model_unit) {
    const std::optional<double> seconds = SecondsPerUnit(options.number_unit);
    if (!seconds || !clock.seconds_per_unit_) {
      return absl::InvalidArgumentError(absl::StrCat(
          "times are declared in '", options.number_unit,
          "', and the model's time_unit is '", model_unit,
          "'; both must be known units of time: ms, s, min, h or d"));
    }
    clock.number_scale_ = *seconds / *clock.seconds_per_unit_;
  }
  if (!options.time_zone.empty()) {
    absl::TimeZone zone;
    if (!absl::LoadTimeZone(options.time_zone, &zone)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "there is no time zone '", options.time_zone,
          "' on this machine; zones have names such as Europe/Berlin or UTC"));
    }
    clock.zone_ = zone;
    clock.zone_name_ = options.time_zone;
  }
  return clock;
}

std::optional<double> RecordClock::hour() const {
  if (!seconds_per_unit_) return std::nullopt;
  return 3600.0 / *seconds_per_unit_;
}

bool RecordClock::Read(std::string_view field, char decimal, double& time) {
  const std::string_view text = TrimCsvField(field);
  if (is_first_ && format_ == TimeFormat::kRecognise) {
    const bool is_date =
        ParseCivilTime(text, DateOrder::kYearFirst).has_value();
    has_dates_ = is_date;
  } else if (format_ != TimeFormat::kRecognise) {
    has_dates_ = format_ != TimeFormat::kNumbers;
  }
  if (has_dates_) return ReadDate(text, time);
  if (!ReadCsvNumber(text, time, decimal)) return false;
  time *= number_scale_;
  if (!std::isfinite(time)) return false;
  is_first_ = false;
  return true;
}

bool RecordClock::ReadDate(std::string_view text, double& time) {
  if (!seconds_per_unit_) return false;
  const std::optional<double> seconds = InZone(text);
  if (!seconds) return false;
  last_seconds_ = *seconds;
  is_first_ = false;
  if (!origin_) origin_ = seconds;
  time = (*seconds - *origin_) / *seconds_per_unit_;
  return true;
}

std::optional<double> RecordClock::InZone(std::string_view text) {
  const std::optional<CivilTime> civil = ParseCivilTime(text, OrderOf(format_));
  if (!civil) return std::nullopt;
  if (civil->zone.has_value() || !zone_) return SecondsSinceEpoch(*civil);

  const double whole = std::floor(civil->second);
  const absl::TimeZone::TimeInfo info = zone_->At(
      absl::CivilSecond(civil->year, civil->month, civil->day, civil->hour,
                        civil->minute, static_cast<int>(whole)));
  if (info.kind == absl::TimeZone::TimeInfo::SKIPPED) return std::nullopt;
  const double fraction = civil->second - whole;
  const double first = Seconds(info.pre) + fraction;
  if (info.kind == absl::TimeZone::TimeInfo::UNIQUE) return first;
  const double second = Seconds(info.post) + fraction;
  return first >= last_seconds_ || second < last_seconds_ ? first : second;
}

std::string RecordClock::Wanted() const {
  if (!has_dates_) return "a finite number";
  if (!seconds_per_unit_) {
    return "of use: dates need a time_unit of s, min, h or d in the model";
  }
  const char* form = format_ == TimeFormat::kDayFirst ? " with the day first"
                     : format_ == TimeFormat::kMonthFirst
                         ? " with the month first"
                         : "";
  if (is_first_) return absl::StrCat("a date and time", form);
  return absl::StrCat(
      "a date and time as the first one is", form,
      zone_ ? absl::StrCat(", one that exists in ", zone_name_) : "");
}

}  // namespace mle
