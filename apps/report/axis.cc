#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

#include "absl/time/civil_time.h"
#include "absl/time/time.h"
#include "apps/report/layout.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

// Values beyond the first are not drawn; smaller ones than the second are drawn
// as zero, or not at all along a logarithmic axis.
constexpr double kLargest = 1e200;
constexpr double kSmallest = 1e-200;

class Extent {
 public:
  explicit Extent(bool log) : log_(log) {}

  void Add(double value) {
    if (!IsShown(value, log_)) return;
    min_ = std::min(min_, value);
    max_ = std::max(max_, value);
  }

  // With `margin` of the length to spare at each end.
  Range ToRange(double margin) const {
    if (min_ > max_) return log_ ? Range{0.1, 10.0} : Range{0.0, 1.0};
    double low = log_ ? std::log10(min_) : min_;
    double high = log_ ? std::log10(max_) : max_;
    const double size = std::max(std::abs(low), std::abs(high));
    const double least = log_ ? 0.01 : std::max(1e-9 * size, kSmallest);
    if (high - low <= least) {
      const double spare = log_ ? 0.5 : size > kSmallest ? 0.5 * size : 1.0;
      low -= spare;
      high += spare;
    } else {
      const double spare = margin * (high - low);
      low -= spare;
      high += spare;
    }
    if (!log_) return {low, high};
    return {std::pow(10.0, low), std::pow(10.0, high)};
  }

 private:
  bool log_;
  double min_ = std::numeric_limits<double>::infinity();
  double max_ = -std::numeric_limits<double>::infinity();
};

// The smallest of 1, 2, 5 times a power of ten that is at least `step`.
double NiceStep(double step) {
  const double power = std::pow(10.0, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= step * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

// Half a place to spare at each end.
Range NamedRange(const Axis& axis) {
  return {-0.5, static_cast<double>(axis.names.size()) - 0.5};
}

// A linear range that ends just short of a tick is made to reach it.
Range ToNearTicks(const Range& range) {
  const double length = range.max - range.min;
  const double step = NiceStep(length / 10.0);
  const double low = std::floor(range.min / step) * step;
  const double high = std::ceil(range.max / step) * step;
  const double near = 0.02 * length;
  return {range.min - low < near ? low : range.min,
          high - range.max < near ? high : range.max};
}

// One form for all labels of an axis.
std::string LinearLabel(double value, double step, double largest) {
  const int step_exponent =
      static_cast<int>(std::floor(std::log10(step) + 1e-9));
  if (largest < 1e5 && step_exponent >= -4) {
    return FormatFixed(value, std::max(0, -step_exponent));
  }
  if (std::abs(value) < 0.5 * step) return "0";
  const int exponent =
      static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
  return FormatScientific(value, exponent - step_exponent + 1);
}

std::vector<Tick> LinearTicks(const Range& range, int wanted) {
  const double step = NiceStep((range.max - range.min) / wanted);
  const double slack = 1e-9;
  const double first = std::ceil(range.min / step - slack);
  const double last = std::floor(range.max / step + slack);
  const double largest = std::max(std::abs(range.min), std::abs(range.max));
  std::vector<Tick> ticks;
  for (int i = 0; first + i <= last; ++i) {
    const double value = (first + i) * step;
    ticks.push_back({value, LinearLabel(value, step, largest)});
  }
  return ticks;
}

std::vector<Tick> LogTicks(const Range& range, int wanted) {
  const double slack = 1e-9;
  const double low = std::log10(range.min);
  const double high = std::log10(range.max);
  const int first = static_cast<int>(std::floor(low + slack));
  const int last = static_cast<int>(std::floor(high + slack));
  const int decades = static_cast<int>(std::floor(high + slack)) -
                      static_cast<int>(std::ceil(low - slack)) + 1;
  // Too short for powers of ten alone: 1, 2, 5, or as on a linear axis.
  if (decades < 2 && high - low < 0.7) return LinearTicks(range, wanted);
  const int stride = std::max(1, (decades + wanted - 1) / wanted);
  std::vector<Tick> ticks;
  for (int e = first; e <= last; ++e) {
    for (int factor = 1; factor <= 9; ++factor) {
      const double value = factor * std::pow(10.0, e);
      const double place = std::log10(value);
      if (place < low - slack || place > high + slack) continue;
      const bool between = decades < 2 && (factor == 2 || factor == 5);
      const bool labelled = factor == 1 ? e % stride == 0 : between;
      if (!labelled && factor > 1 && stride > 1) continue;
      std::string label;
      if (labelled && factor == 1) label = PowerOfTen(e);
      if (labelled && factor > 1) label = FormatSignificant(value, 1);
      ticks.push_back({value, label});
    }
  }
  return ticks;
}

}  // namespace

bool IsShown(double value, bool log) {
  if (!std::isfinite(value) || std::abs(value) > kLargest) return false;
  return !log || value >= kSmallest;
}

Range XRange(const Panel& panel) {
  if (!panel.x.names.empty()) return NamedRange(panel.x);
  if (panel.x.range.has_value()) return *panel.x.range;
  Extent extent(panel.x.log);
  for (const Series& series : panel.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (IsShown(series.y[i], panel.y.log)) extent.Add(series.x[i]);
    }
  }
  // Lines across must not lie upon the frame.
  double margin = 0.0;
  for (const ReferenceLine& line : panel.lines) {
    if (line.orientation != Orientation::kVertical) continue;
    extent.Add(line.value);
    if (panel.x.log) margin = 0.02;
  }
  for (const Marker& marker : panel.markers) {
    if (IsShown(marker.y, panel.y.log)) extent.Add(marker.x);
  }
  for (const Span& span : panel.spans) {
    extent.Add(span.from);
    extent.Add(span.to);
  }
  const Range exact = extent.ToRange(margin);
  return panel.x.log || panel.x.dates.has_value() ? exact : ToNearTicks(exact);
}

Range YRange(const Panel& panel) {
  if (!panel.y.names.empty()) return NamedRange(panel.y);
  if (panel.y.range.has_value()) return *panel.y.range;
  const Range x = XRange(panel);
  const auto seen = [&](double value) {
    return IsShown(value, panel.x.log) && value >= x.min && value <= x.max;
  };
  Extent extent(panel.y.log);
  for (const Series& series : panel.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!seen(series.x[i])) continue;
      extent.Add(series.y[i]);
      if (series.lower.empty()) continue;
      extent.Add(series.lower[i]);
      extent.Add(series.upper[i]);
    }
  }
  for (const ReferenceLine& line : panel.lines) {
    if (line.orientation == Orientation::kHorizontal) extent.Add(line.value);
  }
  for (const Marker& marker : panel.markers) {
    if (seen(marker.x)) extent.Add(marker.y);
  }
  return extent.ToRange(0.05);
}

std::vector<Tick> Ticks(const Range& range, bool log, int wanted) {
  wanted = std::max(2, wanted);
  return log ? LogTicks(range, wanted) : LinearTicks(range, wanted);
}

std::vector<Tick> NamedTicks(const std::vector<std::string>& names) {
  std::vector<Tick> ticks;
  for (const std::string& name : names) {
    ticks.push_back({static_cast<double>(ticks.size()), name});
  }
  return ticks;
}

double Fraction(double value, const Range& range, bool log) {
  if (log) {
    const double low = std::log(range.min);
    return (std::log(value) - low) / (std::log(range.max) - low);
  }
  return (value - range.min) / (range.max - range.min);
}

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
};
// The smallest step of which at most `wanted` fit.
Step StepFor(double seconds, int wanted) {
  const std::tuple<Unit, double, std::vector<int>> units[] = {
      {Unit::kSecond,
       1.0,
       {1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800,
        21600, 43200}},
      {Unit::kDay, kDaySeconds, {1, 2, 7, 14}},
      {Unit::kMonth, kMonthSeconds, {1, 3, 6}},
      {Unit::kYear, kYearSeconds, {1, 2, 5, 10, 20, 50, 100, 200, 500}}};
  for (const auto& [unit, length, counts] : units) {
    for (const int count : counts) {
      if (length * count * wanted >= seconds) return {unit, count};
    }
  }
  return {Unit::kYear, 1000};
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
