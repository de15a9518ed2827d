#include "mle/nonlinear/distributions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "boost/math/distributions/chi_squared.hpp"
#include "boost/math/distributions/fisher_f.hpp"
#include "boost/math/distributions/non_central_chi_squared.hpp"
#include "boost/math/distributions/students_t.hpp"
#include "boost/math/tools/toms748_solve.hpp"
#include "glog/logging.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

namespace bm = boost::math;
namespace policies = boost::math::policies;

// No exceptions: the arguments are checked here, and a tail below the smallest
// double is 0. In double precision, so that every processor has the same
// digits.
using Policy = policies::policy<
    policies::domain_error<policies::ignore_error>,
    policies::pole_error<policies::ignore_error>,
    policies::overflow_error<policies::ignore_error>,
    policies::underflow_error<policies::ignore_error>,
    policies::denorm_error<policies::ignore_error>,
    policies::rounding_error<policies::ignore_error>,
    policies::evaluation_error<policies::ignore_error>,
    policies::indeterminate_result_error<policies::ignore_error>,
    policies::promote_double<false>>;
using ChiSquare = bm::chi_squared_distribution<double, Policy>;
using NoncentralChiSquare =
    bm::non_central_chi_squared_distribution<double, Policy>;
using Fisher = bm::fisher_f_distribution<double, Policy>;
using Student = bm::students_t_distribution<double, Policy>;

// Beyond it F is chi-square over ν to ten digits.
constexpr double kManyDegrees = 1e10;
constexpr double kLargestStudent = 1e150;

// The x > 0 at which a falling tail is `probability`, to rounding. (Boost's own
// quantiles throw whatever the policy: in 1.74 their root finders do not know
// it.)
template <typename Tail>
double InvertTail(const Tail& tail, double probability) {
  double low = 1.0;
  double high = 1.0;
  for (double factor = 2.0; tail(high) > probability; factor *= factor) {
    if (high == std::numeric_limits<double>::max()) return kInfinity;
    low = high;
    high = std::min(high * factor, std::numeric_limits<double>::max());
  }
  for (double factor = 2.0; tail(low) <= probability; factor *= factor) {
    high = low;
    low /= factor;
    if (low == 0.0) return 0.0;
  }
  while (high > 4.0 * low) {
    const double middle = std::sqrt(low) * std::sqrt(high);
    (tail(middle) > probability ? low : high) = middle;
  }
  // Logarithms of tails are almost parabolas; x as a multiple of `low`, so that
  // squares of it are numbers too.
  const auto excess = [&](double multiple) {
    return std::log(
        std::max(tail(multiple * low), std::numeric_limits<double>::min()) /
        probability);
  };
  const double most = high / low;
  const double at_low = excess(1.0);
  const double at_high = excess(most);
  if (!(at_low > 0.0 && at_high < 0.0)) return at_high < 0.0 ? low : high;
  std::uintmax_t evaluations = 200;
  const auto [below, above] = bm::tools::toms748_solve(
      excess, 1.0, most, at_low, at_high,
      bm::tools::eps_tolerance<double>(std::numeric_limits<double>::digits),
      evaluations, Policy());
  return low * (below + 0.5 * (above - below));
}

}  // namespace

double ChiSquareTail(double x, double degrees_of_freedom) {
  CHECK_GT(degrees_of_freedom, 0.0);
  if (!(x > 0.0)) return 1.0;
  if (std::isinf(x)) return 0.0;
  return bm::cdf(bm::complement(ChiSquare(degrees_of_freedom), x));
}

double ChiSquareNoncentrality(double probability, double degrees_of_freedom,
                              double power) {
  CHECK_LT(probability, power);
  CHECK_LT(power, 1.0);
  if (!(probability > 0.0)) return kInfinity;
  const double critical =
      InvertTail([&](double x) { return ChiSquareTail(x, degrees_of_freedom); },
                 probability);
  return InvertTail(
      [&](double noncentrality) {
        return bm::cdf(NoncentralChiSquare(degrees_of_freedom, noncentrality),
                       critical);
      },
      1.0 - power);
}

double FisherTail(double x, double numerator, double denominator) {
  CHECK_GT(numerator, 0.0);
  CHECK_GT(denominator, 0.0);
  if (!(x > 0.0)) return 1.0;
  if (denominator > kManyDegrees) {
    return ChiSquareTail(numerator * x, numerator);
  }
  if (std::isinf(x)) return 0.0;
  return bm::cdf(bm::complement(Fisher(numerator, denominator), x));
}

double FisherQuantile(double probability, double numerator,
                      double denominator) {
  CHECK_GT(numerator, 0.0);
  CHECK_GT(denominator, 0.0);
  if (!(probability > 0.0)) return kInfinity;
  if (probability >= 1.0) return 0.0;
  return InvertTail(
      [&](double x) { return FisherTail(x, numerator, denominator); },
      probability);
}

double StudentTail(double x, double degrees_of_freedom) {
  CHECK_GT(degrees_of_freedom, 0.0);
  if (std::isnan(x)) return x;
  // Beyond what can be squared the tail is a power of x.
  const double near = std::clamp(x, -kLargestStudent, kLargestStudent);
  const double tail =
      bm::cdf(bm::complement(Student(degrees_of_freedom), near));
  return x > near ? tail * std::pow(near / x, degrees_of_freedom) : tail;
}

double StudentTwoSidedQuantile(double probability, double degrees_of_freedom) {
  CHECK_GT(degrees_of_freedom, 0.0);
  if (!(probability > 0.0)) return kInfinity;
  if (probability >= 1.0) return 0.0;
  return InvertTail(
      [&](double x) { return 2.0 * StudentTail(x, degrees_of_freedom); },
      probability);
}

}  // namespace mle
