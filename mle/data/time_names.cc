#include "mle/data/time_names.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/data/civil_time.h"

namespace mle {

TimeNames::TimeNames(const std::string& unit, std::optional<double> origin,
                     const std::string& zone)
    : unit_(unit) {
  const std::optional<double> seconds = SecondsPerUnit(unit);
  if (!origin || !seconds) return;
  origin_ = origin;
  seconds_per_unit_ = *seconds;
  absl::TimeZone loaded;
  if (!zone.empty() && absl::LoadTimeZone(zone, &loaded)) zone_ = loaded;
}

absl::Time TimeNames::TimeOf(double time) const {
  const double seconds = *origin_ + time * seconds_per_unit_;
  return absl::UnixEpoch() + absl::Seconds(std::round(seconds));
}

std::string TimeNames::Short(double time) const {
  if (!has_dates()) return absl::StrFormat("%.7g", time);
  const absl::Time at = TimeOf(time);
  const bool is_minute = absl::FormatTime("%S", at, zone_) == "00";
  return absl::FormatTime(is_minute ? "%Y-%m-%d %H:%M" : "%Y-%m-%d %H:%M:%S",
                          at, zone_);
}

std::string TimeNames::At(double time) const {
  if (has_dates() || unit_.empty()) return Short(time);
  return absl::StrCat(Short(time), " ", unit_);
}

std::string TimeNames::Span(double from, double to) const {
  return absl::StrCat(Short(from), " to ", At(to));
}

std::optional<std::string> TimeNames::Iso(double time) const {
  if (!has_dates()) return std::nullopt;
  return absl::FormatTime("%Y-%m-%dT%H:%M:%S%Ez", TimeOf(time), zone_);
}

}  // namespace mle
