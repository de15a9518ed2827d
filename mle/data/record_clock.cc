#include "mle/data/record_clock.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/civil_time.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/csv_numbers.h"

namespace mle {
namespace {

// 2000 to 2050, in which no clock counts minutes or seconds from elsewhere.
constexpr double kFirstUnix = 946684800.0;
constexpr double kLastUnix = 2524608000.0;

double Seconds(absl::Time time) {
  return absl::ToDoubleSeconds(time - absl::UnixEpoch());
}

// Of the IANA, and not a path or a name for the zone that the machine has
// ("localtime", "libc:localtime"): "Europe/Berlin", "Etc/GMT+5",
// "Fixed/UTC+05:30:00".
bool IsZoneName(absl::string_view name) {
  const bool is_fixed = absl::StartsWith(name, "Fixed/");
  return absl::ascii_isalpha(static_cast<unsigned char>(name[0])) &&
         name != "localtime" && name != "posixrules" &&
         std::all_of(name.begin(), name.end(), [is_fixed](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  absl::StrContains("/_+-", c) || (is_fixed && c == ':');
         });
}

bool IsIn(double number, double from, double to) {
  return number >= from && number < to;
}

}  // namespace

absl::StatusOr<RecordClock> RecordClock::Create(const std::string& model_unit,
                                                const ClockOptions& options) {
  RecordClock clock;
  if (options.format == TimeFormat::kPattern) {
    MLE_ASSIGN_OR_RETURN(clock.form_, FormOfPattern(options.pattern));
  } else {
    clock.form_ = FormOf(options.format);
  }
  clock.has_dates_ = !clock.form_.patterns.empty() || clock.form_.serial;
  clock.model_unit_ = model_unit;
  clock.seconds_per_unit_ = SecondsPerUnit(model_unit);
  clock.has_number_unit_ = !options.number_unit.empty();
  if (clock.has_number_unit_ && options.number_unit != model_unit) {
    const std::optional<double> seconds = SecondsPerUnit(options.number_unit);
    if (!seconds || !clock.seconds_per_unit_) {
      return InvalidArgument(
          "times are declared in '", options.number_unit,
          "', and the model's time_unit is '", model_unit,
          "'; both must be known units of time: ms, s, min, h or d");
    }
    clock.number_scale_ = *seconds / *clock.seconds_per_unit_;
  }
  if (!options.time_zone.empty()) {
    absl::TimeZone zone;
    if (!IsZoneName(options.time_zone) ||
        !absl::LoadTimeZone(options.time_zone, &zone)) {
      return InvalidArgument(
          "there is no time zone '", options.time_zone,
          "' on this machine; zones have names such as Europe/Berlin or UTC");
    }
    clock.zone_ = zone;
    clock.zone_name_ = options.time_zone;
  }
  return clock;
}

// The form of the first time, if that is certain.
void RecordClock::Recognise(std::string_view text, char decimal) {
  is_recognised_ = true;
  for (const TimeForm& form : TimeForms()) {
    if (!form.is_certain) continue;
    if (!ReadCivilTime(text, form)) continue;
    form_ = form;
    has_dates_ = true;
    return;
  }
  double number = 0.0;
  const bool may_be_date = seconds_per_unit_ && !has_number_unit_ &&
                           ReadCsvNumber(text, number, decimal);
  if (may_be_date && IsIn(number, kFirstUnix, kLastUnix)) {
    form_ = FormOf(TimeFormat::kUnix);
  } else if (may_be_date && IsIn(1e-3 * number, kFirstUnix, kLastUnix)) {
    form_ = FormOf(TimeFormat::kUnixMilliseconds);
  } else {
    form_ = FormOf(TimeFormat::kNumbers);
  }
  has_dates_ = form_.serial.has_value();
}

bool RecordClock::Read(std::string_view field, char decimal, double& time) {
  const std::string_view text = TrimCsvField(field);
  if (is_first_ && (is_recognised_ || form_.format == TimeFormat::kRecognise)) {
    Recognise(text, decimal);
  }
  const bool is_read = form_.patterns.empty() ? ReadNumber(text, decimal, time)
                                              : ReadDate(text, time);
  if (is_read) is_first_ = false;
  return is_read;
}

bool RecordClock::ReadNumber(std::string_view text, char decimal,
                             double& time) {
  if (!ReadCsvNumber(text, time, decimal)) return false;
  if (!form_.serial) {
    time *= number_scale_;
    return std::isfinite(time);
  }
  // Excel's days have no digits beyond the millisecond.
  const double seconds =
      std::round(1e3 * time * form_.serial->seconds_per_unit) / 1e3;
  return std::isfinite(seconds) &&
         SetTime(form_.serial->origin + seconds, time);
}

bool RecordClock::ReadDate(std::string_view text, double& time) {
  const std::optional<CivilTime> civil = ReadCivil(text);
  if (!civil) return false;
  const std::optional<double> seconds = InZone(*civil);
  return seconds && SetTime(*seconds, time);
}

// By the pattern that read the last one, mostly.
std::optional<CivilTime> RecordClock::ReadCivil(std::string_view text) {
  std::optional<CivilTime> civil = form_.patterns[pattern_].Read(text);
  if (civil) return civil;
  for (std::size_t p = 0; p < form_.patterns.size(); ++p) {
    if (p == pattern_) continue;
    civil = form_.patterns[p].Read(text);
    if (!civil) continue;
    pattern_ = p;
    return civil;
  }
  return std::nullopt;
}

bool RecordClock::SetTime(double seconds, double& time) {
  if (!seconds_per_unit_) return false;
  last_seconds_ = seconds;
  if (!origin_) origin_ = seconds;
  time = (seconds - *origin_) / *seconds_per_unit_;
  return true;
}

std::optional<double> RecordClock::InZone(const CivilTime& civil) {
  if (civil.zone.has_value() || !zone_) return SecondsSinceEpoch(civil);

  const double whole = std::floor(civil.second);
  const absl::TimeZone::TimeInfo info = zone_->At(
      absl::CivilSecond(civil.year, civil.month, civil.day, civil.hour,
                        civil.minute, static_cast<int>(whole)));
  if (info.kind == absl::TimeZone::TimeInfo::SKIPPED) return std::nullopt;
  const double fraction = civil.second - whole;
  const double first = Seconds(info.pre) + fraction;
  if (info.kind == absl::TimeZone::TimeInfo::UNIQUE) return first;
  const double second = Seconds(info.post) + fraction;
  if (is_descending_) {
    return !last_seconds_ || second <= *last_seconds_ || first > *last_seconds_
               ? second
               : first;
  }
  return !last_seconds_ || first >= *last_seconds_ || second < *last_seconds_
             ? first
             : second;
}

std::string RecordClock::Wanted(std::string_view field) const {
  if (has_dates_ && !seconds_per_unit_) {
    return "of use: dates need a time_unit of s, min, h or d in the model";
  }
  if (!is_first_) {
    if (form_.patterns.empty()) return "a finite number";
    return absl::StrCat(
        "a date and time as the first one is",
        zone_ ? absl::StrCat(", one that exists in ", zone_name_) : "");
  }
  if (!is_recognised_) {
    return absl::StrCat(
        "a time of the form that time_format = ", form_.name, " declares",
        form_.example.empty() ? "" : absl::StrCat(" (", form_.example, ")"));
  }
  // Forms that must be declared, and what the text is then.
  std::vector<std::string> possible;
  for (const TimeForm& form : TimeForms()) {
    const auto civil = ReadCivilTime(TrimCsvField(field), form);
    if (!civil || form.is_certain) continue;
    possible.push_back(absl::StrCat(
        "time_format = ", form.name, " (",
        FormatIsoTime(SecondsSinceEpoch(*civil)).substr(0, 10), ")"));
  }
  if (possible.empty()) {
    return "a time: a finite number, or a date and time of a form that is "
           "known (2024-02-29T12:34:56, 2024/02/29 12:34, 29-Feb-24 12:34); "
           "declare another one, such as time_format = '%d.%m.%Y %H:%M'";
  }
  return absl::StrCat(
      "certain: days and months may stand in either order; declare ",
      absl::StrJoin(possible, " or "));
}

}  // namespace mle
