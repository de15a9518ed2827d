// Tails and quantiles of the distributions that tests and intervals need.
//
// Relative accuracy 1e-11 or better, for tails down to the smallest normal
// double and quantiles up to 1e150. Smaller tails are 0.

#ifndef MLE_NONLINEAR_DISTRIBUTIONS_H_
#define MLE_NONLINEAR_DISTRIBUTIONS_H_

namespace mle {

// P(X > x) for X chi-square of ν > 0 degrees of freedom; 1 for x ≤ 0.
double ChiSquareTail(double x, double degrees_of_freedom);

// The noncentrality λ for which noncentral χ² of ν degrees of freedom exceeds
// with probability `power` what χ² exceeds with `probability` < `power`: of a
// departure that a test at this level finds so often. Infinite for probability
// 0, which small levels may round to.
double ChiSquareNoncentrality(double probability, double degrees_of_freedom,
                              double power);

// P(X > x) for X of Fisher's F distribution with ν1, ν2 > 0; ν2 may be
// infinite.
double FisherTail(double x, double numerator, double denominator);

// The x that F exceeds with `probability` in [0, 1]; ν2 may be infinite.
double FisherQuantile(double probability, double numerator, double denominator);

// P(t > x) for Student's t with ν > 0, which may be infinite.
double StudentTail(double x, double degrees_of_freedom);

// The x that |t| of Student's distribution exceeds with `probability` in
// [0, 1]: 1.96 for 0.05 and ν = ∞.
double StudentTwoSidedQuantile(double probability, double degrees_of_freedom);

// The same for 0.05 and ν = ∞: of 95 % intervals.
inline constexpr double kNormalQuantile = 1.959963984540054;

}  // namespace mle

#endif  // MLE_NONLINEAR_DISTRIBUTIONS_H_
