#include "mle/nonlinear/robust_loss.h"

#include <cmath>
#include <random>

#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::VectorXd;

// ρ(x) in closed form.
double Cost(RobustLoss loss, double x) {
  if (loss == RobustLoss::kHuber && std::abs(x) > 1.345) {
    return 1.345 * (std::abs(x) - 0.5 * 1.345);
  }
  if (loss == RobustLoss::kCauchy) {
    return 0.5 * 2.3849 * 2.3849 * std::log1p(x * x / (2.3849 * 2.3849));
  }
  return 0.5 * x * x;
}

class RobustLossTest : public ::testing::TestWithParam<RobustLoss> {};

TEST_P(RobustLossTest, WeightsAndCurvaturesAreDerivativesOfTheCost) {
  const double h = 1e-5;
  for (double x = -7.03; x < 7.0; x += 0.1) {
    const double psi =
        (Cost(GetParam(), x + h) - Cost(GetParam(), x - h)) / (2.0 * h);
    EXPECT_NEAR(RobustWeight(GetParam(), x) * x, psi, 1e-8);
    const auto slope = [&](double at) {
      return RobustWeight(GetParam(), at) * at;
    };
    EXPECT_NEAR(RobustCurvature(GetParam(), x),
                (slope(x + h) - slope(x - h)) / (2.0 * h), 1e-6);
    EXPECT_EQ(RobustWeight(GetParam(), x), RobustWeight(GetParam(), -x));
    EXPECT_LE(RobustWeight(GetParam(), x), 1.0);
    EXPECT_GT(RobustWeight(GetParam(), x), 0.0);
  }
  EXPECT_EQ(RobustWeight(GetParam(), 0.0), 1.0);
}

TEST_P(RobustLossTest, DoNotDependOnUnits) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  VectorXd residuals(501);
  for (double& r : residuals) r = normal(engine);
  residuals(7) = 40.0;
  const RobustWeights one = ComputeRobustWeights(GetParam(), residuals);
  const RobustWeights other =
      ComputeRobustWeights(GetParam(), 1024.0 * residuals);
  EXPECT_EQ(other.weights, one.weights);
  EXPECT_EQ(other.scale, 1024.0 * one.scale);
  EXPECT_EQ(other.variance_factor, one.variance_factor);
}

// The variance of the minimiser of Σ ρ((z_k − m)/s) over samples of a normal
// distribution with outliers, against what weights and factor make of it.
TEST_P(RobustLossTest, VarianceOfALocationIsAsStated) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const int samples = 400;
  const int runs = 2000;
  double squares = 0.0;
  double stated = 0.0;
  for (int run = 0; run < runs; ++run) {
    VectorXd z(samples);
    for (double& value : z) {
      value = normal(engine);
      if (uniform(engine) < 0.02) value += uniform(engine) < 0.5 ? 20.0 : -20.0;
    }
    double mean = 0.0;
    RobustWeights robust;
    for (int round = 0; round < 50; ++round) {
      robust = ComputeRobustWeights(GetParam(), z.array() - mean);
      mean = robust.weights.dot(z) / robust.weights.sum();
    }
    const VectorXd residuals = z.array() - mean;
    squares += mean * mean / runs;
    stated += robust.variance_factor *
              robust.weights.dot(residuals.cwiseAbs2()) / samples /
              robust.weights.sum() / runs;
  }
  // A variance of 2000 runs has a relative deviation of 3 %; three of them, and
  // first-order terms of 1/400.
  EXPECT_NEAR(squares / stated, 1.0, 0.1);
}

INSTANTIATE_TEST_SUITE_P(
    Losses, RobustLossTest,
    ::testing::Values(RobustLoss::kHuber, RobustLoss::kCauchy),
    [](const auto& test) {
      return std::string(test.param == RobustLoss::kHuber ? "Huber" : "Cauchy");
    });

TEST(RobustLossTest, ConstantsGiveNineteenTwentiethsOfTheEfficiency) {
  // Of the normal distribution: E[ψ′]² / E[ψ²] by the trapezoidal rule.
  for (const RobustLoss loss : {RobustLoss::kHuber, RobustLoss::kCauchy}) {
    double slope = 0.0;
    double square = 0.0;
    const double h = 1e-3;
    for (double x = -10.0; x < 10.0; x += h) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * M_PI);
      const double psi = RobustWeight(loss, x) * x;
      slope += h * density * RobustCurvature(loss, x);
      square += h * density * psi * psi;
    }
    EXPECT_NEAR(slope * slope / square, 0.95, 5e-4);
  }
}

TEST(RobustLossTest, NothingToWeigh) {
  EXPECT_EQ(ComputeRobustWeights(RobustLoss::kHuber, VectorXd()).weights.size(),
            0);
  const RobustWeights zeros =
      ComputeRobustWeights(RobustLoss::kCauchy, VectorXd::Zero(5));
  EXPECT_EQ(zeros.weights, VectorXd::Ones(5));
  EXPECT_EQ(zeros.variance_factor, 1.0);
  EXPECT_EQ(
      ComputeRobustWeights(RobustLoss::kNone, VectorXd::Random(9)).weights,
      VectorXd::Ones(9));
}

}  // namespace
}  // namespace mle
