// The range of an axis and its ticks, and where a value lies on it.

#ifndef APPS_REPORT_AXIS_H_
#define APPS_REPORT_AXIS_H_

#include <string>
#include <vector>

#include "apps/report/figure.h"

namespace mle::report {

struct Tick {
  double value = 0.0;
  std::string label = {};  // empty: a minor tick
};

// True if a value can be shown on such an axis: finite, of a size that can
// still be scaled, and positive if logarithmic.
bool IsShown(double value, bool log);

// The ranges of a panel's axes: as asked for, else what its series, lines,
// spans and markers need. Along x just that; along y with a twentieth to spare
// at each end. 0 … 1 (0.1 … 10 if logarithmic) if there is nothing to show.
Range XRange(const Panel& panel);
Range YRange(const Panel& panel);

// About `wanted` (≥ 2) labelled ticks within `range`. Linear: at multiples of
// 1, 2 or 5 times a power of ten. Logarithmic: at powers of ten, or between
// them where the range is short; minor ticks at 2 … 9 times a power of ten.
std::vector<Tick> Ticks(const Range& range, bool log, int wanted);

// At 0, 1, 2, …, one for each name.
std::vector<Tick> NamedTicks(const std::vector<std::string>& names);

// 0 at range.min, 1 at range.max.
double Fraction(double value, const Range& range, bool log);

// At most `wanted` (≥ 2) and one of them within `range`, all labelled; where
// the range has no two whole seconds, as on an axis without dates.
std::vector<Tick> DateTicks(const Range& range, const DateScale& dates,
                            int wanted);

}  // namespace mle::report

#endif  // APPS_REPORT_AXIS_H_
