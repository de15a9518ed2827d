// The least value of a function of one variable in an interval, by Brent's
// method (Boost.Math). Internal to mle/nonlinear
// and mle/filter.

#ifndef MLE_NONLINEAR_BRENT_SEARCH_H_
#define MLE_NONLINEAR_BRENT_SEARCH_H_

#include <cstdint>

#include "boost/math/tools/minima.hpp"

namespace mle {

// Where `value` is least between `low` and `high`, to some `tolerance_bits`
// bits of half the interval, whatever is far from zero. `value` is asked at
// most 40 times; it may keep what it finds.
template <typename Value>
double SearchLeast(double low, double high, int tolerance_bits,
                   const Value& value) {
  constexpr std::uintmax_t kMostSearched = 40;
  const double centre = 0.5 * (low + high);
  const double half = 0.5 * (high - low);
  std::uintmax_t evaluations = kMostSearched;
  return centre + half * boost::math::tools::brent_find_minima(
                             [&](double x) { return value(centre + half * x); },
                             -1.0, 1.0, tolerance_bits, evaluations)
                             .first;
}

}  // namespace mle

#endif  // MLE_NONLINEAR_BRENT_SEARCH_H_
