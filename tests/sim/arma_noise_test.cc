#include "sim/arma_noise.h"

#include <cmath>
#include <complex>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::sim {
namespace {

using Eigen::RowVectorXd;
using ::testing::HasSubstr;

RowVectorXd Draw(const ArmaOptions& options, int samples, int seed = 1) {
  GaussianNoise source(seed, 0);
  return DrawArmaNoise(source, options, samples);
}

double Autocovariance(const RowVectorXd& noise, Eigen::Index lag) {
  const Eigen::Index n = noise.size() - lag;
  return noise.head(n).dot(noise.tail(n)) / static_cast<double>(n);
}

// Of some 10,000 independent values or more: a standard error of 1.5 %.
constexpr int kSamples = 200000;

TEST(ArmaNoiseTest, WithoutPolesAndZerosItIsWhite) {
  const RowVectorXd noise = Draw({.variance = 4.0}, kSamples);
  EXPECT_NEAR(Autocovariance(noise, 0), 4.0, 0.1);
  EXPECT_NEAR(Autocovariance(noise, 1), 0.0, 0.1);
}

// ξ_k = φ ξ_{k−1} + e_k + θ e_{k−1}: ρ₁ = (1 + φθ)(φ + θ) / (1 + 2φθ + θ²), ρ_k
// = φ ρ_{k−1} (Box and Jenkins, Time Series Analysis, 1976, sec. 3.4.3).
TEST(ArmaNoiseTest, APoleAndAZeroGiveTheKnownCorrelations) {
  const double phi = 0.8;
  const double theta = 0.5;
  const RowVectorXd noise =
      Draw({.poles = {phi}, .zeros = {-theta}, .variance = 0.25}, kSamples);
  const double first = (1.0 + phi * theta) * (phi + theta) /
                       (1.0 + 2.0 * phi * theta + theta * theta);
  EXPECT_NEAR(Autocovariance(noise, 0), 0.25, 0.015);
  EXPECT_NEAR(Autocovariance(noise, 1) / Autocovariance(noise, 0), first, 0.01);
  EXPECT_NEAR(Autocovariance(noise, 4) / Autocovariance(noise, 0),
              first * std::pow(phi, 3), 0.02);
}

// Yule and Walker for ξ_k = φ₁ ξ_{k−1} + φ₂ ξ_{k−2} + e_k: ρ₁ = φ₁ / (1 − φ₂).
TEST(ArmaNoiseTest, ComplexPolesComeInPairs) {
  const std::complex<double> pole = std::polar(0.9, 0.5);
  const RowVectorXd noise = Draw({.poles = {pole}, .variance = 1.0}, kSamples);
  const double phi1 = 2.0 * pole.real();
  const double phi2 = -std::norm(pole);
  EXPECT_NEAR(Autocovariance(noise, 0), 1.0, 0.05);
  EXPECT_NEAR(Autocovariance(noise, 1) / Autocovariance(noise, 0),
              phi1 / (1.0 - phi2), 0.01);
}

// What Π (1 − p q⁻¹) leaves of an autoregression is the white noise it is of.
TEST(ArmaNoiseTest, ThePolesWhitenIt) {
  const RowVectorXd noise =
      Draw({.poles = {0.95, -0.5}, .variance = 1.0}, kSamples);
  const Eigen::Index n = noise.size() - 2;
  const RowVectorXd rest =
      noise.tail(n) - 0.45 * noise.segment(1, n) - 0.475 * noise.head(n);
  for (const int lag : {1, 2, 3}) {
    EXPECT_NEAR(Autocovariance(rest, lag) / Autocovariance(rest, 0), 0.0, 0.01);
  }
}

TEST(ArmaNoiseTest, ItIsStationaryFromTheFirstSample) {
  const ArmaOptions options{
      .poles = {0.999, 0.7}, .zeros = {0.2}, .variance = 2.0};
  double first = 0.0;
  double product = 0.0;
  constexpr int kRuns = 4000;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const RowVectorXd noise = Draw(options, 2, seed);
    first += noise[0] * noise[0] / kRuns;
    product += noise[0] * noise[1] / kRuns;
  }
  EXPECT_NEAR(first, 2.0, 0.2);  // a standard error of 2.2 %
  EXPECT_NEAR(product, 2.0, 0.2);
}

TEST(ArmaNoiseTest, TheVarianceScalesTheSamePath) {
  const RowVectorXd one = Draw({.poles = {0.9}, .variance = 1.0}, 100);
  const RowVectorXd four = Draw({.poles = {0.9}, .variance = 4.0}, 100);
  EXPECT_LE((four - 2.0 * one).norm(), 1e-12);
  EXPECT_EQ(Draw({.poles = {0.9}, .variance = 0.0}, 100).norm(), 0.0);
}

TEST(ArmaNoiseTest, PolesOutsideTheUnitCircleAreRefused) {
  EXPECT_THAT(std::string(ArmaOptions{.poles = {1.0}}.Validate().message()),
              HasSubstr("1 + 0i is not inside a circle of radius 0.9999"));
  EXPECT_FALSE((ArmaOptions{.poles = {{0.8, 0.7}}}.Validate().ok()));
  EXPECT_FALSE(ArmaOptions{.poles = {NAN}}.Validate().ok());
  EXPECT_FALSE((ArmaOptions{.poles = {}, .zeros = {1001.0}}.Validate().ok()));
  EXPECT_FALSE((ArmaOptions{.poles = std::vector<std::complex<double>>(9)}
                    .Validate()
                    .ok()));
  EXPECT_FALSE(ArmaOptions{.variance = -1.0}.Validate().ok());
  EXPECT_TRUE((ArmaOptions{.poles = {0.999}, .zeros = {3.0}}.Validate().ok()));
}

}  // namespace
}  // namespace mle::sim
