#include "apps/report/date_ticks.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "absl/time/civil_time.h"
#include "absl/time/time.h"

namespace mle::report {
namespace {

constexpr double kDaySeconds = 86400.0;
// Lengths of a month and a year, to choose a step by.
constexpr double kMonthSeconds = 30.4 * kDaySeconds;
constexpr double kYearSeconds = 365.0 * kDaySeconds;
constexpr int kMostTicks = 1000;

enum class Unit { kSecond, kDay, kMonth, kYear };

struct Step {
  Unit unit = Unit::kSecond;
  int count = 1;
  double seconds = 1.0;  // about
};

// The smallest step of which at most `wanted` fit.
Step StepFor(double seconds, int wanted) {
  const auto fits = [&](double step) { return step * wanted >= seconds; };
  for (const int count : {1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800,
                          3600, 7200, 10800, 21600, 43200}) {
    if (fits(count)) return {Unit::kSecond, count, 1.0 * count};
  }
  for (const int count : {1, 2, 7, 14}) {
    if (fits(kDaySeconds * count))
      return {Unit::kDay, count, kDaySeconds * count};
  }
  for (const int count : {1, 3, 6}) {
    if (fits(kMonthSeconds * count))
      return {Unit::kMonth, count, kMonthSeconds * count};
  }
  for (const int count : {1, 2, 5, 10, 20, 50, 100, 200, 500}) {
    if (fits(kYearSeconds * count))
      return {Unit::kYear, count, kYearSeconds * count};
  }
  return {Unit::kYear, 1000, 1000.0 * kYearSeconds};
}

absl::Time At(double value, const DateScale& dates) {
  return absl::UnixEpoch() +
         absl::Seconds(dates.origin + value * dates.seconds_per_unit);
}

// The largest multiple of `count` that is not above `number`.
std::int64_t Floored(std::int64_t number, int count) {
  const std::int64_t rest = ((number % count) + count) % count;
  return number - rest;
}

// The k-th tick from the one at or before `first`.
absl::CivilSecond TickAt(const absl::CivilSecond& first, const Step& step,
                         int k) {
  const int ahead = k * step.count;
  switch (step.unit) {
    case Unit::kSecond: {
      const absl::CivilDay day(first);
      const std::int64_t since = first - absl::CivilSecond(day);
      return absl::CivilSecond(day) + Floored(since, step.count) + ahead;
    }
    case Unit::kDay: {
      // Weeks begin on Monday: 1970-01-05 is one.
      const absl::CivilDay monday(1970, 1, 5);
      const absl::CivilDay day(first);
      return absl::CivilSecond(monday + Floored(day - monday, step.count) +
                               ahead);
    }
    case Unit::kMonth: {
      const absl::CivilMonth begin(first.year(), 1);
      return absl::CivilSecond(begin + Floored(first.month() - 1, step.count) +
                               ahead);
    }
    case Unit::kYear:
      return absl::CivilSecond(
          absl::CivilYear(Floored(first.year(), step.count)) + ahead);
  }
  return first;
}

std::string LabelOf(absl::Time time, const Step& step, absl::TimeZone zone) {
  const bool is_midnight = absl::FormatTime("%H%M%S", time, zone) == "000000";
  const char* form = "%H:%M";
  if (step.unit == Unit::kYear) {
    form = "%Y";
  } else if (step.unit == Unit::kMonth) {
    form = "%b %Y";
  } else if (step.unit == Unit::kDay || is_midnight) {
    form = "%e %b";
  } else if (step.count < 60) {
    form = "%H:%M:%S";
  }
  std::string label = absl::FormatTime(form, time, zone);
  if (label[0] == ' ') label.erase(0, 1);
  return label;
}

}  // namespace

std::vector<Tick> DateTicks(const Range& range, const DateScale& dates,
                            int wanted) {
  wanted = std::max(2, wanted);
  const double seconds = (range.max - range.min) * dates.seconds_per_unit;
  if (!(seconds >= 2.0)) return Ticks(range, false, wanted);
  const Step step = StepFor(seconds, wanted);
  const absl::CivilSecond first =
      absl::ToCivilSecond(At(range.min, dates), dates.zone);
  std::vector<Tick> ticks;
  for (int k = 0; k < kMostTicks; ++k) {
    const absl::Time time = absl::FromCivil(TickAt(first, step, k), dates.zone);
    const double value =
        (absl::ToDoubleSeconds(time - absl::UnixEpoch()) - dates.origin) /
        dates.seconds_per_unit;
    if (value > range.max) break;
    // An hour that clocks leave out has one place only.
    const bool is_new = ticks.empty() || value > ticks.back().value;
    if (value < range.min || !is_new) continue;
    ticks.push_back({value, LabelOf(time, step, dates.zone)});
  }
  return ticks;
}

}  // namespace mle::report
