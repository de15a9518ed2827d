#include "mle/nonlinear/distributions.h"

#include <cmath>

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

TEST(ChiSquareTailTest, IsItsClosedForms) {
  for (const double x : {0.01, 0.7, 3.0, 12.0, 60.0, 700.0}) {
    // ν = 1: twice the normal tail; ν = 2 and 6: a Poisson sum of x/2.
    EXPECT_NEAR(ChiSquareTail(x, 1.0) / std::erfc(std::sqrt(0.5 * x)), 1.0,
                1e-10);
    const double h = 0.5 * x;
    EXPECT_NEAR(ChiSquareTail(x, 2.0) / std::exp(-h), 1.0, 1e-10);
    EXPECT_NEAR(
        ChiSquareTail(x, 6.0) / (std::exp(-h) * (1.0 + h + 0.5 * h * h)), 1.0,
        1e-10);
  }
  EXPECT_EQ(ChiSquareTail(0.0, 3.0), 1.0);
  EXPECT_EQ(ChiSquareTail(-1.0, 3.0), 1.0);
}

TEST(FisherTailTest, IsItsClosedForms) {
  for (const double x : {0.02, 0.9, 4.0, 50.0}) {
    // ν1 = 2: (1 + 2x/ν2)^(−ν2/2).
    for (const double nu : {1.0, 4.0, 17.5, 1000.0}) {
      EXPECT_NEAR(
          FisherTail(x, 2.0, nu) / std::pow(1.0 + 2.0 * x / nu, -0.5 * nu), 1.0,
          1e-9);
    }
    // ν1 = ν2 = 1: the square of a Cauchy variable.
    EXPECT_NEAR(FisherTail(x, 1.0, 1.0),
                1.0 - 2.0 / M_PI * std::atan(std::sqrt(x)), 1e-12);
    EXPECT_NEAR(FisherTail(x, 3.0, kInfinity), ChiSquareTail(3.0 * x, 3.0),
                1e-15);
    EXPECT_NEAR(FisherTail(x, 3.0, 1e8), ChiSquareTail(3.0 * x, 3.0), 1e-6);
  }
}

// Down to 1e-300 a tail is still right to ten digits, and below the smallest
// double it is 0.
TEST(TailTest, KeepsItsAccuracyWhereItIsTiny) {
  for (const double x : {100.0, 700.0, 1380.0}) {
    const double h = 0.5 * x;
    EXPECT_NEAR(ChiSquareTail(x, 1.0) / std::erfc(std::sqrt(h)), 1.0, 1e-10);
    EXPECT_NEAR(ChiSquareTail(x, 4.0) / (std::exp(-h) * (1.0 + h)), 1.0, 1e-10);
    EXPECT_NEAR(
        StudentTail(std::sqrt(x), kInfinity) / (0.5 * std::erfc(std::sqrt(h))),
        1.0, 1e-10);
  }
  for (const double x : {1e8, 1e75, 1e150}) {
    EXPECT_NEAR(FisherTail(x, 2.0, 4.0) / (4.0 / (x * x)), 1.0,
                4.1 / x + 1e-10);
    EXPECT_NEAR(StudentTail(x, 1.0) * x * M_PI, 1.0, 1e-10);
  }
  for (const double x : {50.0, 690.0}) {
    EXPECT_NEAR(FisherTail(x, 2.0, 1e9) / std::exp(-5e8 * std::log1p(2e-9 * x)),
                1.0, 1e-7);  // the closed form itself loses digits
  }
  EXPECT_EQ(ChiSquareTail(1e6, 3.0), 0.0);
  EXPECT_EQ(ChiSquareTail(kInfinity, 3.0), 0.0);
  EXPECT_EQ(FisherTail(1e300, 2.0, 50.0), 0.0);
  EXPECT_EQ(FisherTail(kInfinity, 2.0, 50.0), 0.0);
  EXPECT_EQ(StudentTail(kInfinity, 5.0), 0.0);
  EXPECT_EQ(StudentTail(-kInfinity, 5.0), 1.0);
}

TEST(QuantileTest, IsItsClosedForms) {
  for (const double p : {1e-300, 1e-100, 1e-12, 1e-3, 0.05, 0.5, 0.99}) {
    // ν1 = 2: ν2/2 (p^(−2/ν2) − 1), for ν2 = ∞ −ln p.
    for (const double nu : {2.0, 4.0, 17.5, 1000.0}) {
      EXPECT_NEAR(FisherQuantile(p, 2.0, nu) /
                      (0.5 * nu * std::expm1(-2.0 / nu * std::log(p))),
                  1.0, 1e-10)
          << p << " " << nu;
    }
    EXPECT_NEAR(FisherQuantile(p, 2.0, kInfinity) / -std::log(p), 1.0, 1e-10);
    // ν = 1, Cauchy's distribution, and ν = 2.
    if (p > 1e-150) {  // beyond, t² is too large
      EXPECT_NEAR(StudentTwoSidedQuantile(p, 1.0) * std::tan(0.5 * M_PI * p),
                  1.0, 1e-10);
    }
    EXPECT_NEAR(StudentTwoSidedQuantile(p, 2.0) /
                    ((1.0 - p) * std::sqrt(2.0 / (p * (2.0 - p)))),
                1.0, 1e-10);
  }
}

TEST(QuantileTest, InvertsTheTail) {
  for (const double probability : {1e-300, 1e-12, 1e-3, 0.05, 0.5, 0.99}) {
    for (const double nu : {2.0, 4.0, 33.3, kInfinity}) {
      const double x = FisherQuantile(probability, 3.0, nu);
      EXPECT_NEAR(FisherTail(x, 3.0, nu) / probability, 1.0, 1e-8);
    }
  }
}

// Nothing throws, wherever the argument is.
TEST(TailTest, FallsFromOneToZero) {
  for (double nu = 1e-3; nu < 1e13; nu *= 1.9) {
    double chi_square = 1.0;
    double fisher = 1.0;
    double student = 0.5;
    for (double x = 1e-300; x < 1e140; x *= 3.7) {
      const double now[] = {ChiSquareTail(x, nu), FisherTail(x, 3.0, nu),
                            StudentTail(x, nu)};
      const double slack = 1.0 + 1e-11;
      ASSERT_TRUE(now[0] >= 0.0 && now[0] <= chi_square * slack) << x << nu;
      ASSERT_TRUE(now[1] >= 0.0 && now[1] <= fisher * slack) << x << nu;
      ASSERT_TRUE(now[2] >= 0.0 && now[2] <= student * slack) << x << nu;
      chi_square = now[0];
      fisher = now[1];
      student = now[2];
    }
  }
}

TEST(QuantileTest, GoesUpWithTheTailForAnyDegrees) {
  for (double nu = 0.3; nu < 1e12; nu *= 1.7) {
    double last_f = kInfinity;
    double last_t = kInfinity;
    for (double p = 1e-200; p < 1.0; p = std::sqrt(p) * 0.999) {
      if (p > 0.9) break;
      const double f = FisherQuantile(p, 3.0, nu);
      const double t = StudentTwoSidedQuantile(p, nu);
      EXPECT_TRUE(f <= last_f && f > 0.0) << p << " " << nu;
      EXPECT_TRUE(t <= last_t && t > 0.0) << p << " " << nu;
      last_f = f;
      last_t = t;
    }
  }
}

// Tables for the power of χ² tests (Haynam, Govindarajulu and Leone, 1970).
// Of few degrees of freedom the tail is (c x)^−ν: squares of x overflow long
// before it is small.
TEST(QuantileTest, StudentHasItsPowersToTheEnd) {
  constexpr double kNu = 0.25;
  const double ratio = StudentTail(1e140, kNu) / StudentTail(1e300, kNu);
  EXPECT_NEAR(std::log10(ratio), kNu * 160.0, 1e-9);
  const double x = StudentTwoSidedQuantile(1e-60, kNu);
  EXPECT_NEAR(std::log10(2.0 * StudentTail(x, kNu)), -60.0, 1e-12);
  EXPECT_GT(x, 1e200);
  EXPECT_EQ(StudentTail(kInfinity, kNu), 0.0);
  EXPECT_EQ(StudentTail(-1e200, kNu), 1.0);
  EXPECT_EQ(StudentTwoSidedQuantile(1e-100, kNu), kInfinity);
}

TEST(NoncentralityTest, HasItsTabulatedValues) {
  EXPECT_NEAR(ChiSquareNoncentrality(0.05, 1.0, 0.9), 10.507, 1e-3);
  EXPECT_NEAR(ChiSquareNoncentrality(0.05, 2.0, 0.9), 12.654, 1e-3);
  EXPECT_NEAR(ChiSquareNoncentrality(0.01, 1.0, 0.9), 14.879, 1e-3);
  // (z_α/2 + z_power)² but for the other tail.
  const double sum =
      StudentTwoSidedQuantile(1e-4, 1e12) + StudentTwoSidedQuantile(2e-3, 1e12);
  EXPECT_NEAR(ChiSquareNoncentrality(1e-4, 1.0, 0.999), sum * sum, 1e-6);
}

// What levels of options may round to.
TEST(QuantileTest, OfCertainAndImpossibleEvents) {
  EXPECT_EQ(StudentTwoSidedQuantile(0.0, 5.0), kInfinity);
  EXPECT_EQ(StudentTwoSidedQuantile(1.0, 5.0), 0.0);
  EXPECT_EQ(FisherQuantile(0.0, 3.0, 5.0), kInfinity);
  EXPECT_EQ(FisherQuantile(1.0, 3.0, 5.0), 0.0);
  EXPECT_EQ(ChiSquareNoncentrality(0.0, 3.0, 0.9), kInfinity);
}

TEST(QuantileTest, StudentHasItsTabulatedValues) {
  // To the digits of the tables.
  EXPECT_NEAR(StudentTwoSidedQuantile(0.05, kInfinity), 1.959964, 1e-6);
  EXPECT_NEAR(StudentTwoSidedQuantile(0.05, 10.0), 2.228139, 1e-6);
  EXPECT_NEAR(StudentTwoSidedQuantile(0.01, 4.0), 4.604095, 1e-6);
  EXPECT_NEAR(StudentTwoSidedQuantile(0.5, 1.0), 1.0, 1e-9);
}

}  // namespace
}  // namespace mle
