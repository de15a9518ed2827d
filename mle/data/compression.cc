#include "mle/data/compression.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace mle {
namespace {

// Rounding of double and of single precision, relative to the largest sample.
constexpr double kDouble = 1e-12;
constexpr double kSingle = 3e-7;
constexpr double kLeastStraight = 0.3;
constexpr double kLeastRepeated = 0.4;
// Archived values, at the least, and their share among those whose neighbours
// are interpolated.
constexpr int kLeastArchived = 10;
constexpr double kIsolated = 0.5;
// Bends larger than rounding by less than this factor, over larger ones: a
// smooth signal has bends of every size.
struct Gap {
  double factor;
  double share;
  double least_large;  // of the samples of a signal that moves
};
constexpr Gap kExact = {10.0, 0.1, 0.0};
// Simulated without noise and printed, set points leave a few bends.
constexpr Gap kPrinted = {4.0, 0.25, 0.02};
constexpr double kLeastAlternating = 0.45;
constexpr double kLeastSizes = 0.3;  // different ones among the steps
// A laboratory or an analyser: the shortest period in samples, the share of the
// distances of steps that are multiples of it, to within a share of it (stamps
// are not exact), and the share of the steps that are of more than one digit.
constexpr double kShortestPeriod = 3.0;
constexpr double kPeriodic = 0.8;
constexpr double kOffPeriod = 0.2;
constexpr double kOnePeriod = 1.5;   // at most, of the shortest distances
constexpr double kFewPeriods = 3.5;  // that stamps leave apart
constexpr double kLargeSteps = 0.1;
constexpr double kSamePhase = 0.95;
constexpr int kMostDigits = 9;
constexpr std::size_t kSamplesForDigits = 5000;

double ScaleOfRows(const std::vector<SampleRow>& rows) {
  double scale = 0.0;
  for (const SampleRow& row : rows) {
    for (const double value : row) {
      if (std::isfinite(value)) scale = std::max(scale, std::abs(value));
    }
  }
  return scale;
}

// 10^−d, with d the fewest decimals that all samples have; 0 if there are more
// than nine.
double LastDigit(const std::vector<SampleRow>& rows) {
  std::vector<double> values;
  for (const SampleRow& row : rows) {
    for (const double value : row) {
      if (std::isfinite(value) && values.size() < kSamplesForDigits) {
        values.push_back(value);
      }
    }
  }
  double per_unit = 1.0;
  for (int digits = 0; digits <= kMostDigits; ++digits, per_unit *= 10.0) {
    const bool fits =
        std::all_of(values.begin(), values.end(), [&](double value) {
          const double multiple = value * per_unit;
          return std::abs(multiple - std::round(multiple)) <=
                 1e-6 + 1e-12 * std::abs(multiple);
        });
    if (fits) return 1.0 / per_unit;
  }
  return 0.0;
}

enum class Bend : char { kUnknown, kFlat, kNone, kSmall, kLarge };

// How each sample lies against the line through its neighbours.
std::vector<Bend> BendsOf(const SampleRow& row, double tolerance,
                          double factor) {
  const int n = static_cast<int>(row.size());
  std::vector<Bend> bends(n, Bend::kUnknown);
  for (int k = 1; k + 1 < n; ++k) {
    const double before = row(k) - row(k - 1);
    const double after = row(k + 1) - row(k);
    const double bend = std::abs(after - before);
    if (!std::isfinite(bend)) continue;
    if (bend > tolerance) {
      bends[k] = bend > factor * tolerance ? Bend::kLarge : Bend::kSmall;
    } else {
      const bool flat =
          std::abs(before) <= tolerance && std::abs(after) <= tolerance;
      bends[k] = flat ? Bend::kFlat : Bend::kNone;
    }
  }
  return bends;
}

bool IsStraight(Bend bend) {
  return bend == Bend::kNone || bend == Bend::kFlat;
}

struct BendCounts {
  double straight = 0.0;  // in runs of two or more, in a signal that moves
  double moving = 0.0;
  double small = 0.0;
  double large = 0.0;
  double isolated = 0.0;     // large, beside a straight one
  double alternating = 0.0;  // large, of other sign than the large one before
};

void Count(const SampleRow& row, const std::vector<Bend>& bends,
           BendCounts& counts) {
  const int n = static_cast<int>(bends.size());
  double last = 0.0;
  for (int k = 1; k + 1 < n; ++k) {
    if (bends[k] == Bend::kUnknown || bends[k] == Bend::kFlat) continue;
    counts.moving += 1.0;
    if (bends[k] == Bend::kNone &&
        (bends[k - 1] == Bend::kNone || bends[k + 1] == Bend::kNone)) {
      counts.straight += 1.0;
    }
    if (bends[k] == Bend::kSmall) counts.small += 1.0;
    if (bends[k] != Bend::kLarge) continue;
    counts.large += 1.0;
    if (IsStraight(bends[k - 1]) || IsStraight(bends[k + 1])) {
      counts.isolated += 1.0;
    }
    const double bend = row(k + 1) - 2.0 * row(k) + row(k - 1);
    if (bend * last < 0.0) counts.alternating += 1.0;
    last = bend;
  }
}

// Whether the rows are straight lines to within `tolerance`; if so, in `found`.
bool FindLines(const std::vector<SampleRow>& rows, double tolerance, Gap gap,
               bool must_alternate, Compression& found) {
  BendCounts counts;
  for (const SampleRow& row : rows) {
    Count(row, BendsOf(row, tolerance, gap.factor), counts);
  }
  const bool alternates =
      counts.alternating >= kLeastAlternating * counts.large;
  if (counts.large < kLeastArchived ||
      counts.large < gap.least_large * counts.moving ||
      counts.straight < kLeastStraight * counts.moving ||
      counts.small > gap.share * counts.large ||
      counts.isolated < kIsolated * counts.large ||
      (must_alternate && !alternates)) {
    return false;
  }
  found.kind = Compression::Kind::kLinear;
  for (const SampleRow& row : rows) {
    std::vector<bool>& interpolated = found.interpolated.emplace_back();
    for (const Bend bend : BendsOf(row, tolerance, gap.factor)) {
      interpolated.push_back(IsStraight(bend));
    }
  }
  return true;
}

// Runs of equal samples and the steps between them.
struct HoldCounts {
  double pairs = 0.0;       // of neighbours
  double repeated = 0.0;    // of which equal
  double runs = 0.0;        // of two or more
  double after_step = 0.0;  // steps that a repeated sample follows
  std::vector<double> steps;
};

void Count(const SampleRow& row, double tolerance, HoldCounts& counts) {
  bool stepped = false;
  bool running = false;
  for (Eigen::Index k = 1; k < row.size(); ++k) {
    const double step = std::abs(row(k) - row(k - 1));
    if (!std::isfinite(step)) {
      stepped = false;
      running = false;
      continue;
    }
    counts.pairs += 1.0;
    if (step > tolerance) {
      counts.steps.push_back(step);
      stepped = true;
      running = false;
      continue;
    }
    counts.repeated += 1.0;
    if (!running) counts.runs += 1.0;
    if (stepped) counts.after_step += 1.0;
    running = true;
    stepped = false;
  }
}

// The number of values that differ among sorted numbers.
double Different(const std::vector<double>& sorted, double tolerance) {
  double different = sorted.empty() ? 0.0 : 1.0;
  for (std::size_t s = 1; s < sorted.size(); ++s) {
    if (sorted[s] - sorted[s - 1] > tolerance) different += 1.0;
  }
  return different;
}

// Samples at which a held signal changes, of all rows.
struct Changes {
  std::vector<std::vector<int>> at;
  std::vector<double> distances;
};

Changes ChangesOf(const std::vector<SampleRow>& rows, double tolerance) {
  Changes changes;
  for (const SampleRow& row : rows) {
    std::vector<int>& at = changes.at.emplace_back();
    double last = std::nan("");
    for (Eigen::Index k = 0; k < row.size(); ++k) {
      if (!std::isfinite(row(k))) continue;
      if (std::abs(row(k) - last) > tolerance) {
        if (!at.empty()) {
          changes.distances.push_back(static_cast<double>(k - at.back()));
        }
        at.push_back(static_cast<int>(k));
      }
      last = row(k);
    }
  }
  return changes;
}

// The period in samples that distances are multiples of; 0: none. At rest many
// measurements repeat the one before, so that distances of a few periods tell.
double PeriodOf(std::vector<double> distances) {
  if (std::ssize(distances) < kLeastArchived) return 0.0;
  std::sort(distances.begin(), distances.end());
  const double shortest = distances[distances.size() / 10];
  if (shortest < kShortestPeriod) return 0.0;
  const auto up_to = [&](double distance) {
    return std::upper_bound(distances.begin(), distances.end(), distance);
  };
  const double period =
      distances[(up_to(kOnePeriod * shortest) - distances.begin()) / 2];
  const auto last = up_to(kFewPeriods * period);
  const auto few = static_cast<double>(last - distances.begin());
  const auto fits = static_cast<double>(
      std::count_if(distances.begin(), last, [&](double distance) {
        const double multiple = distance / period;
        return std::abs(multiple - std::round(multiple)) <= kOffPeriod;
      }));
  return few >= kLeastArchived && fits >= kPeriodic * few ? period : 0.0;
}

// Marks all samples as interpolated but those that were measured: changes, and
// where nearly all changes have one phase of the period every sample of that
// phase, at which the same value was measured again.
void TakeMeasured(const std::vector<SampleRow>& rows, const Changes& changes,
                  double period, Compression& found) {
  const auto whole = std::max(static_cast<int>(std::round(period)), 1);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::vector<int> phases(whole, 0);
    for (const int at : changes.at[r]) ++phases[at % whole];
    const auto usual = std::max_element(phases.begin(), phases.end());
    const bool is_exact =
        *usual >= kSamePhase * static_cast<double>(changes.at[r].size());
    std::vector<bool>& interpolated = found.interpolated.emplace_back(
        static_cast<std::size_t>(rows[r].size()), true);
    for (const int at : changes.at[r]) interpolated[at] = false;
    if (changes.at[r].empty()) continue;
    for (Eigen::Index k = 0; is_exact && k < rows[r].size(); ++k) {
      if (k % whole == usual - phases.begin()) interpolated[k] = false;
    }
  }
}

// Whether steps come at multiples of a period, some of them larger than the
// smallest, which is the rounding; if so, in `found`.
bool FindSampled(const std::vector<SampleRow>& rows, double tolerance,
                 const std::vector<double>& sorted_steps, Compression& found) {
  const auto large = static_cast<double>(std::count_if(
      sorted_steps.begin(), sorted_steps.end(),
      [&](double step) { return step > 1.5 * sorted_steps.front(); }));
  if (large < kLargeSteps * static_cast<double>(sorted_steps.size())) {
    return false;
  }
  const Changes changes = ChangesOf(rows, tolerance);
  const double period = PeriodOf(changes.distances);
  if (period == 0.0) return false;
  found.kind = Compression::Kind::kHeld;
  found.is_sampled = true;
  TakeMeasured(rows, changes, period, found);
  return true;
}

void FindHolds(const std::vector<SampleRow>& rows, double scale,
               Compression& found) {
  const double tolerance = kDouble * scale;
  HoldCounts counts;
  for (const SampleRow& row : rows) Count(row, tolerance, counts);
  const auto steps = static_cast<double>(counts.steps.size());
  if (counts.runs < kLeastArchived ||
      counts.repeated < kLeastRepeated * counts.pairs ||
      counts.after_step < kLeastRepeated * steps) {
    return;
  }
  std::sort(counts.steps.begin(), counts.steps.end());
  if (FindSampled(rows, tolerance, counts.steps, found)) return;
  if (Different(counts.steps, 10.0 * tolerance) < kLeastSizes * steps) return;
  found.kind = Compression::Kind::kHeld;
  for (const SampleRow& row : rows) {
    std::vector<bool>& interpolated = found.interpolated.emplace_back(
        static_cast<std::size_t>(row.size()), false);
    for (Eigen::Index k = 1; k < row.size(); ++k) {
      interpolated[k] = std::abs(row(k) - row(k - 1)) <= tolerance;
    }
  }
}

void CountArchived(const std::vector<SampleRow>& rows, Compression& found) {
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (Eigen::Index k = 0; k < rows[r].size(); ++k) {
      if (!std::isfinite(rows[r](k))) continue;
      ++found.samples;
      const bool made_up =
          found.kind != Compression::Kind::kNone && found.interpolated[r][k];
      found.archived += made_up ? 0 : 1;
    }
  }
}

}  // namespace

double Compression::ArchivedShare() const {
  return samples > 0 ? static_cast<double>(archived) / samples : 1.0;
}

Compression FindCompression(const std::vector<SampleRow>& rows, Holding own) {
  Compression found;
  const double scale = ScaleOfRows(rows);
  const double digit = 2.01 * LastDigit(rows);
  const bool lines =
      digit > kDouble * scale
          ? FindLines(rows, digit, kPrinted, true, found)
          : FindLines(rows, kDouble * scale, kExact, false, found) ||
                FindLines(rows, kSingle * scale, kExact, true, found);
  if (!lines && own == Holding::kNever) FindHolds(rows, scale, found);
  CountArchived(rows, found);
  return found;
}

Compression HeldBetween(const std::vector<SampleRow>& rows, double period) {
  Compression found;
  found.kind = Compression::Kind::kHeld;
  found.is_sampled = true;
  TakeMeasured(rows, ChangesOf(rows, kDouble * ScaleOfRows(rows)), period,
               found);
  CountArchived(rows, found);
  return found;
}

}  // namespace mle
