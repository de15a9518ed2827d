#include "mle/maintain/common_factor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "mle/base/double_limits.h"

namespace mle {
namespace {

// The records determine a gain whose standard error is at most this share of
// its size.
constexpr double kDetermined = 0.2;
constexpr double kSignRange = 4.0;
constexpr double kNotAgeing = 20.0;
constexpr double kLargeRange = 2.0;
constexpr double kLeastGainFactor = 4.0;
constexpr double kFactorTolerance = 0.1;
constexpr double kTellingTolerance = 0.05;
constexpr double kExactTolerance = 0.02;
constexpr std::array<double, 8> kTelling = {
    1.8, 1.0 / 1.8, 60.0, 1.0 / 60.0, 100., 1.0 / 100., 1000.0, 1e-3};
constexpr double kNearTelling = 1.3;  // for factors beyond kNotAgeing
// One gain in so many may differ: three of four have to agree, six of eight.
constexpr std::size_t kOneOfWhichMayDiffer = 4;

// The telling factor next to `factor`, if that is within `range` of it.
std::optional<double> Telling(double factor, double range) {
  for (const double telling : kTelling) {
    if (std::abs(std::log(factor / telling)) <= std::log(range)) return telling;
  }
  return std::nullopt;
}

// Gains, over the model's, of the elements of a row or column.
struct Common {
  int elements = 0;
  int determined = 0;
  double factor = 0.0;  // geometric mean, negative if all are
  double spread = 1.0;  // largest ratio to it
  double error = 0.0;   // largest relative one
  bool one_sign = true;
};

// A gain over the model's that the records determine.
struct Ratio {
  double value = 0.0;
  double error = 0.0;  // relative

  double log_size() const { return std::log(std::abs(value)); }
};

Common CommonOf(const std::vector<Ratio>& determined, int elements) {
  Common common;
  common.elements = elements;
  common.determined = static_cast<int>(determined.size());
  if (determined.empty()) return common;
  double logs = 0.0;
  int negative = 0;
  for (const Ratio& gain : determined) {
    negative += gain.value < 0.0 ? 1 : 0;
    logs += gain.log_size();
    common.error = std::max(common.error, gain.error);
  }
  logs /= common.determined;
  common.factor = (negative > 0 ? -1.0 : 1.0) * std::exp(logs);
  common.one_sign = negative == 0 || negative == common.determined;
  for (const Ratio& gain : determined) {
    common.spread =
        std::max(common.spread, std::exp(std::abs(gain.log_size() - logs)));
  }
  return common;
}

// Leaves out the gain that is farthest from the median; one of another sign is
// farther than any of the same.
void LeaveOutFarthest(std::vector<Ratio>& gains) {
  const auto middle = gains.begin() + std::ssize(gains) / 2;
  std::nth_element(
      gains.begin(), middle, gains.end(),
      [](const Ratio& a, const Ratio& b) { return a.value < b.value; });
  const Ratio median = *middle;
  const auto distance = [&median](const Ratio& gain) {
    const bool turned = gain.value * median.value < 0.0;
    return turned ? kInfinity : std::abs(gain.log_size() - median.log_size());
  };
  gains.erase(std::max_element(gains.begin(), gains.end(),
                               [&](const Ratio& a, const Ratio& b) {
                                 return distance(a) < distance(b);
                               }));
}

// The mistake that the gains of a row or column make likely, at one length of
// blocks; `exact`: it has to be so at all of them.
struct Suspicion {
  double factor = 1.0;
  bool exact = false;
  int elements = 0;  // of the row or column
};

// Elements may have aged besides: the factor is what is left of the gains.
std::optional<Suspicion> SuspectSign(const Common& common) {
  const double size = std::abs(common.factor);
  const bool near =
      size * common.spread <= kSignRange && common.spread / size <= kSignRange;
  if (!near) return std::nullopt;
  return Suspicion{common.factor, false};
}

std::optional<Suspicion> Suspect(const Common& common) {
  if (common.determined == 0 || !common.one_sign) return std::nullopt;
  const double size = std::abs(common.factor);
  const double tolerance = 1.0 + kTellingTolerance + 2.0 * common.error;
  if (common.elements == 1) {
    if (common.factor < 0.0) return SuspectSign(common);
    if (common.error > kTellingTolerance) return std::nullopt;
    // One gain has aged by such a factor as well.
    if (size < kLeastGainFactor && size > 1.0 / kLeastGainFactor) {
      return std::nullopt;
    }
    // A unit's factor is exact, one of ageing comes near it by chance.
    const std::optional<double> telling =
        Telling(size, 1.0 + kExactTolerance + 2.0 * common.error);
    if (!telling.has_value()) return std::nullopt;
    return Suspicion{*telling, true};
  }
  if (size >= kNotAgeing || size <= 1.0 / kNotAgeing) {
    if (common.spread > kLargeRange || common.factor < 0.0) return std::nullopt;
    return Suspicion{Telling(size, kNearTelling).value_or(size), false};
  }
  if (common.determined < 2) return std::nullopt;
  if (common.factor < 0.0) return SuspectSign(common);
  if (common.error > kTellingTolerance) return std::nullopt;
  const std::optional<double> telling = Telling(size, tolerance);
  if (telling.has_value() && common.spread <= tolerance) {
    return Suspicion{*telling, true};
  }
  if ((size >= kLeastGainFactor || size <= 1.0 / kLeastGainFactor) &&
      common.spread <= 1.0 + kFactorTolerance) {
    return Suspicion{size, true};
  }
  return std::nullopt;
}

// The factor that the gains of a row or column have in common; an aged element
// does not hide what all others have.
std::optional<Suspicion> Suspect(const GainEstimates& fit, bool row,
                                 int channel) {
  std::vector<Ratio> gains;
  int elements = 0;
  const Eigen::Index n = row ? fit.values.cols() : fit.values.rows();
  for (Eigen::Index e = 0; e < n; ++e) {
    const double gain = row ? fit.values(channel, e) : fit.values(e, channel);
    const double error = row ? fit.errors(channel, e) : fit.errors(e, channel);
    if (!std::isfinite(error)) continue;
    ++elements;
    if (error <= kDetermined * std::abs(gain)) {
      gains.push_back({gain, error / std::abs(gain)});
    }
  }
  const std::size_t most = gains.size() / kOneOfWhichMayDiffer;
  std::optional<Suspicion> suspicion = Suspect(CommonOf(gains, elements));
  for (std::size_t left_out = 0; left_out < most && !suspicion.has_value();
       ++left_out) {
    LeaveOutFarthest(gains);
    suspicion = Suspect(CommonOf(gains, elements));
  }
  if (suspicion.has_value()) suspicion->elements = elements;
  return suspicion;
}

bool AreClose(double a, double b) {
  return std::abs(std::log(std::abs(a / b))) <=
         std::log(1.0 + kFactorTolerance);
}

}  // namespace

std::optional<CommonFactor> FindCommonFactor(
    const std::vector<GainEstimates>& estimates, bool row, int channel) {
  std::optional<CommonFactor> found;
  std::optional<Suspicion> first;
  bool agree = true;
  for (const GainEstimates& estimate : estimates) {
    const std::optional<Suspicion> suspicion = Suspect(estimate, row, channel);
    if (&estimate == &estimates.front()) first = suspicion;
    agree = agree && suspicion.has_value() && first.has_value() &&
            AreClose(suspicion->factor, first->factor);
    // One that ageing cannot make: as the longest blocks have it, which forgive
    // most.
    if (suspicion.has_value() && !suspicion->exact) {
      found = {suspicion->factor, suspicion->elements, false};
    }
  }
  if (found.has_value() || !first.has_value()) return found;
  return CommonFactor{first->factor, first->elements, !agree};
}

}  // namespace mle
