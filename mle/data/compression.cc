#include "mle/data/compression.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace mle {
namespace {

// Of the largest sample: rounding of double and of single precision.
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

// Of sample k against the line through its neighbours.
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

// Of sorted numbers, those that differ from the one before.
double Different(const std::vector<double>& sorted, double tolerance) {
  double different = sorted.empty() ? 0.0 : 1.0;
  for (std::size_t s = 1; s < sorted.size(); ++s) {
    if (sorted[s] - sorted[s - 1] > tolerance) different += 1.0;
  }
  return different;
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
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (Eigen::Index k = 0; k < rows[r].size(); ++k) {
      if (!std::isfinite(rows[r](k))) continue;
      ++found.samples;
      const bool made_up =
          found.kind != Compression::Kind::kNone && found.interpolated[r][k];
      found.archived += made_up ? 0 : 1;
    }
  }
  return found;
}

}  // namespace mle
