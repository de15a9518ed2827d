#include "mle/nonlinear/distributions.h"

#include <cmath>
#include <limits>

#include "glog/logging.h"

namespace mle {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kTiny = 1e-300;
constexpr int kMaxTerms = 100'000;
// Beyond it F is chi-square over ν to ten digits.
constexpr double kManyDegrees = 1e10;

// ln Γ(a), a > 0. std::lgamma writes the sign to a global: a race of threads.
double LogGamma(double a) {
  int sign = 0;
  return ::lgamma_r(a, &sign);
}

// Q(a, x), the upper regularised incomplete gamma function; x > 0.
double UpperGamma(double a, double x) {
  const double factor = std::exp(a * std::log(x) - x - LogGamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a;
    double sum = term;
    for (int n = 1; n < kMaxTerms && term > kEpsilon * sum; ++n) {
      term *= x / (a + n);
      sum += term;
    }
    return 1.0 - factor * sum;
  }
  // Lentz's evaluation of the continued fraction.
  double b = x + 1.0 - a;
  double c = 1.0 / kTiny;
  double d = 1.0 / b;
  double h = d;
  for (int n = 1; n < kMaxTerms; ++n) {
    const double coefficient = -n * (n - a);
    b += 2.0;
    d = coefficient * d + b;
    if (std::abs(d) < kTiny) d = kTiny;
    c = b + coefficient / c;
    if (std::abs(c) < kTiny) c = kTiny;
    d = 1.0 / d;
    h *= c * d;
    if (std::abs(c * d - 1.0) < kEpsilon) break;
  }
  return factor * h;
}

double BetaFraction(double a, double b, double x) {
  double c = 1.0;
  double d = 1.0 - (a + b) * x / (a + 1.0);
  if (std::abs(d) < kTiny) d = kTiny;
  d = 1.0 / d;
  double h = d;
  const auto advance = [&](double coefficient) {
    d = 1.0 + coefficient * d;
    if (std::abs(d) < kTiny) d = kTiny;
    c = 1.0 + coefficient / c;
    if (std::abs(c) < kTiny) c = kTiny;
    d = 1.0 / d;
    h *= c * d;
    return c * d;
  };
  for (int m = 1; m < kMaxTerms; ++m) {
    const int m2 = 2 * m;
    advance(m * (b - m) * x / ((a + m2 - 1.0) * (a + m2)));
    const double change =
        advance(-(a + m) * (a + b + m) * x / ((a + m2) * (a + m2 + 1.0)));
    if (std::abs(change - 1.0) < kEpsilon) break;
  }
  return h;
}

// I_x(a, b), the regularised incomplete beta function; y = 1 − x, given apart
// because it may be small.
double IncompleteBeta(double a, double b, double x, double y) {
  if (x <= 0.0) return 0.0;
  if (y <= 0.0) return 1.0;
  const double factor = std::exp(LogGamma(a + b) - LogGamma(a) - LogGamma(b) +
                                 a * std::log(x) + b * std::log(y));
  if (x < (a + 1.0) / (a + b + 2.0)) return factor * BetaFraction(a, b, x) / a;
  return 1.0 - factor * BetaFraction(b, a, y) / b;
}

}  // namespace

double ChiSquareTail(double x, double degrees_of_freedom) {
  CHECK_GT(degrees_of_freedom, 0.0);
  if (!(x > 0.0)) return 1.0;
  return UpperGamma(0.5 * degrees_of_freedom, 0.5 * x);
}

double FisherTail(double x, double numerator, double denominator) {
  CHECK_GT(numerator, 0.0);
  CHECK_GT(denominator, 0.0);
  if (!(x > 0.0)) return 1.0;
  if (denominator > kManyDegrees) {
    return ChiSquareTail(numerator * x, numerator);
  }
  const double total = denominator + numerator * x;
  return IncompleteBeta(0.5 * denominator, 0.5 * numerator, denominator / total,
                        numerator * x / total);
}

double FisherQuantile(double probability, double numerator,
                      double denominator) {
  CHECK_GT(probability, 0.0);
  CHECK_LT(probability, 1.0);
  double low = 0.0;
  double high = 1.0;
  while (FisherTail(high, numerator, denominator) > probability &&
         high < 1e300) {
    low = high;
    high *= 2.0;
  }
  while (high - low > 1e-12 * high) {
    const double middle = 0.5 * (low + high);
    if (FisherTail(middle, numerator, denominator) > probability) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return 0.5 * (low + high);
}

double StudentTail(double x, double degrees_of_freedom) {
  const double half = 0.5 * FisherTail(x * x, 1.0, degrees_of_freedom);
  return x >= 0.0 ? half : 1.0 - half;
}

double StudentTwoSidedQuantile(double probability, double degrees_of_freedom) {
  return std::sqrt(FisherQuantile(probability, 1.0, degrees_of_freedom));
}

}  // namespace mle
