#include "mle/nonlinear/distributions.h"

#include <cmath>

#include "boost/math/distributions/chi_squared.hpp"
#include "boost/math/distributions/fisher_f.hpp"
#include "boost/math/distributions/students_t.hpp"
#include "boost/math/special_functions/beta.hpp"
#include "glog/logging.h"

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
using Fisher = bm::fisher_f_distribution<double, Policy>;
using Student = bm::students_t_distribution<double, Policy>;

// Beyond it F is chi-square over ν to ten digits.
constexpr double kManyDegrees = 1e10;

}  // namespace

double ChiSquareTail(double x, double degrees_of_freedom) {
  CHECK_GT(degrees_of_freedom, 0.0);
  if (!(x > 0.0)) return 1.0;
  if (std::isinf(x)) return 0.0;
  return bm::cdf(bm::complement(ChiSquare(degrees_of_freedom), x));
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
  CHECK_GT(probability, 0.0);
  CHECK_LT(probability, 1.0);
  CHECK_GT(numerator, 0.0);
  CHECK_GT(denominator, 0.0);
  if (denominator > kManyDegrees) {
    return bm::quantile(bm::complement(ChiSquare(numerator), probability)) /
           numerator;
  }
  // X = ν2/(ν2 + ν1 F) is beta distributed, and P(F > x) a lower tail of it.
  // Boost's quantile of the F distribution takes an upper tail, and loses small
  // probabilities in 1 − p for ν1 = ν2 = 2 (1.74).
  double rest = 0.0;  // 1 − X
  const double X = bm::ibeta_inv(0.5 * denominator, 0.5 * numerator,
                                 probability, &rest, Policy());
  return denominator / numerator * (rest / X);
}

double StudentTail(double x, double degrees_of_freedom) {
  CHECK_GT(degrees_of_freedom, 0.0);
  if (std::isnan(x)) return x;
  return bm::cdf(bm::complement(Student(degrees_of_freedom), x));
}

double StudentTwoSidedQuantile(double probability, double degrees_of_freedom) {
  CHECK_GT(probability, 0.0);
  CHECK_LT(probability, 1.0);
  CHECK_GT(degrees_of_freedom, 0.0);
  return bm::quantile(
      bm::complement(Student(degrees_of_freedom), 0.5 * probability));
}

}  // namespace mle
