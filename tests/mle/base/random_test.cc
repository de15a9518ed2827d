#include "mle/base/random.h"

#include <cmath>

#include "gtest/gtest.h"

namespace mle {
namespace {

constexpr int kDraws = 100'000;

double Correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd x = a.array() - a.mean();
  const Eigen::VectorXd y = b.array() - b.mean();
  return x.dot(y) / (x.norm() * y.norm());
}

Eigen::VectorXd Draws(std::uint64_t seed, std::uint64_t stream,
                      std::uint32_t substream = 0) {
  return GaussianNoise(seed, stream, substream).DrawMatrix(kDraws, 1, 1.0);
}

// Five standard errors of each estimate from N draws.
TEST(GaussianNoiseTest, HasTheMomentsOfANormalDistribution) {
  const Eigen::ArrayXd x =
      GaussianNoise(7, 3).DrawMatrix(kDraws, 1, 0.5).col(0).array() / 0.5;
  const double root = std::sqrt(static_cast<double>(kDraws));
  EXPECT_NEAR(x.mean(), 0.0, 5.0 / root);
  EXPECT_NEAR(x.square().mean(), 1.0, 5.0 * std::sqrt(2.0) / root);
  EXPECT_NEAR(x.cube().mean(), 0.0, 5.0 * std::sqrt(15.0) / root);
  EXPECT_NEAR(x.square().square().mean(), 3.0, 5.0 * std::sqrt(96.0) / root);
}

TEST(GaussianNoiseTest, IsWhite) {
  const Eigen::VectorXd x = Draws(7, 3);
  const double bound = 5.0 / std::sqrt(static_cast<double>(kDraws));
  for (const int lag : {1, 2, 3, 10}) {
    EXPECT_NEAR(Correlation(x.head(kDraws - lag), x.tail(kDraws - lag)), 0.0,
                bound);
  }
}

TEST(GaussianNoiseTest, RepeatsForTheSameSeedAndStream) {
  EXPECT_EQ(Draws(5, 2, 1), Draws(5, 2, 1));
}

TEST(GaussianNoiseTest, SeedsStreamsAndSubstreamsAreIndependent) {
  const double bound = 5.0 / std::sqrt(static_cast<double>(kDraws));
  const Eigen::VectorXd reference = Draws(5, 2);
  EXPECT_NEAR(Correlation(reference, Draws(6, 2)), 0.0, bound);
  EXPECT_NEAR(Correlation(reference, Draws(5, 3)), 0.0, bound);
  EXPECT_NEAR(Correlation(reference, Draws(2, 5)), 0.0, bound);
  EXPECT_NEAR(Correlation(reference, Draws(5, 2, 1)), 0.0, bound);
  EXPECT_NEAR(Correlation(reference, Draws(5 + (1ULL << 32U), 2)), 0.0, bound);
  EXPECT_NEAR(Correlation(reference, Draws(5, 2 + (1ULL << 32U))), 0.0, bound);
}

TEST(GaussianNoiseTest, MatrixIsFilledColumnByColumnWithSingleDraws) {
  GaussianNoise one(9, 0);
  GaussianNoise other(9, 0);
  const Eigen::MatrixXd matrix = one.DrawMatrix(3, 4, 2.0);
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(matrix(i, j), other.Draw(2.0));
  }
}

TEST(GaussianNoiseTest, DeviationScalesAndUsesTheSameDraws) {
  const Eigen::VectorXd x = GaussianNoise(1, 1).DrawMatrix(100, 1, 1.0);
  EXPECT_EQ(GaussianNoise(1, 1).DrawMatrix(100, 1, 4.0), 4.0 * x);
  EXPECT_EQ(GaussianNoise(1, 1).DrawMatrix(100, 1, 0.0), 0.0 * x);
  GaussianNoise silent(1, 1);
  silent.Draw(0.0);
  EXPECT_EQ(silent.Draw(1.0), x[1]);
}

}  // namespace
}  // namespace mle
