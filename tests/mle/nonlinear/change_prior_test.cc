#include "mle/nonlinear/change_prior.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "Eigen/LU"
#include "gtest/gtest.h"
#include "mle/nonlinear/model_average.h"

namespace mle {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// One element, K₀ = 2, T₀ = 10, L₀ = 2: units 2, 10 and 12.
OutputPoint Initial() {
  OutputPoint point;
  point.values = {{2.0, 10.0, 2.0}};
  point.SetCells(0.5);
  return point;
}

OutputFit FitAt(const Vector3d& change, const Matrix3d& covariance) {
  OutputFit fit;
  fit.point = Initial();
  ElementValues& v = fit.point.values[0];
  v.gain += change(0);
  v.time_scale += change(1);
  v.delay += change(2);
  fit.free = {true};
  fit.covariance = covariance;
  fit.degrees_of_freedom = VectorXd::Constant(3, 100.0);
  return fit;
}

struct Moments {
  VectorXd change;  // from the initial values
  MatrixXd covariance;
  double weights = 0.0;
};

Moments MomentsOf(const OutputFit& fit,
                  const std::vector<LinearEstimate>& estimates) {
  const VectorXd base = ParametersOf(fit.point) - ParametersOf(Initial());
  Moments moments{VectorXd::Zero(3), MatrixXd::Zero(3, 3), 0.0};
  for (const LinearEstimate& e : estimates) {
    moments.change += e.weight * (base + e.change);
    moments.weights += e.weight;
  }
  for (const LinearEstimate& e : estimates) {
    const VectorXd apart = base + e.change - moments.change;
    moments.covariance += e.weight * (e.covariance + apart * apart.transpose());
  }
  return moments;
}

// All 64 choices, by the formula of the header.
Moments Enumerate(const Vector3d& change, const Matrix3d& covariance) {
  const std::array<double, 4> scales = {0.02, 0.2, 0.6, 2.0};
  const Vector3d units(2.0, 10.0, 12.0);
  double total = 0.0;
  Vector3d mean = Vector3d::Zero();
  Matrix3d square = Matrix3d::Zero();
  for (int c = 0; c < 64; ++c) {
    double weight = 1.0;
    Vector3d variances;
    for (int k = 0; k < 3; ++k) {
      const int s = (c >> (2 * k)) & 3;
      weight *= s == 0 ? 1.0 / 2 : 1.0 / 6;
      variances(k) = std::pow(scales[s] * units(k), 2);
    }
    const Matrix3d D = variances.asDiagonal();
    const Matrix3d inverse = (covariance + D).inverse();
    weight *= std::sqrt(inverse.determinant()) *
              std::exp(-0.5 * change.dot(inverse * change));
    const Vector3d own = D * inverse * change;
    total += weight;
    mean += weight * own;
    square += weight * (D - D * inverse * D + own * own.transpose());
  }
  mean /= total;
  return {mean, square / total - mean * mean.transpose(), 1.0};
}

Matrix3d Correlated(double k, double t, double l, double correlation) {
  Matrix3d covariance = Vector3d(k * k, t * t, l * l).asDiagonal();
  covariance(0, 1) = covariance(1, 0) = correlation * k * t;
  return covariance;
}

TEST(ChangePriorTest, IsTheSumOverAllChoices) {
  const struct {
    Vector3d change;
    Matrix3d covariance;
  } cases[] = {
      {{-0.7, 3.0, 0.1}, Correlated(0.2, 4.0, 0.3, 0.9)},
      {{0.02, 0.1, -0.05}, Correlated(0.5, 6.0, 2.0, -0.5)},
      {{3.0, 0.0, 4.0}, Correlated(0.01, 0.1, 0.05, 0.0)},
  };
  for (const auto& c : cases) {
    const OutputFit fit = FitAt(c.change, c.covariance);
    const Moments moments = MomentsOf(fit, IntegrateChanges(fit, Initial()));
    const Moments exact = Enumerate(c.change, c.covariance);
    EXPECT_NEAR(moments.weights, 1.0, 1e-12);
    for (int k = 0; k < 3; ++k) {
      const double error = std::sqrt(exact.covariance(k, k));
      EXPECT_NEAR(moments.change(k), exact.change(k), 0.05 * error) << k;
      EXPECT_NEAR(std::sqrt(moments.covariance(k, k)), error, 0.05 * error)
          << k;
    }
  }
}

TEST(ChangePriorTest, WhatTheRecordsSayClearlyStays) {
  const Vector3d change(-0.8, 5.0, 1.0);
  const Matrix3d covariance = Correlated(0.002, 0.02, 0.01, 0.3);
  const OutputFit fit = FitAt(change, covariance);
  const Moments moments = MomentsOf(fit, IntegrateChanges(fit, Initial()));
  for (int k = 0; k < 3; ++k) {
    const double error = std::sqrt(covariance(k, k));
    EXPECT_NEAR(moments.change(k), change(k), 0.05 * error) << k;
    EXPECT_NEAR(std::sqrt(moments.covariance(k, k)), error, 0.01 * error) << k;
  }
}

// K and T are hardly told from each other; a change of K alone lies on the
// ridge as well as that of both.
TEST(ChangePriorTest, OneParameterIsPreferredToTwo) {
  const Matrix3d covariance = Correlated(0.15, 2.25, 0.1, 0.99);
  // On the ridge through (−0.6, 0), one standard error along it; T alone would
  // be three standard errors the other way.
  const Vector3d change(-0.6 + 0.15, 2.25, 0.0);
  const OutputFit fit = FitAt(change, covariance);
  const Moments moments = MomentsOf(fit, IntegrateChanges(fit, Initial()));
  EXPECT_NEAR(moments.change(0), -0.6, 0.1);
  EXPECT_LT(std::abs(moments.change(1)), 1.2);
  EXPECT_LT(moments.covariance(1, 1), 0.8 * covariance(1, 1));
}

TEST(ChangePriorTest, WhatIsNotDeterminedStaysAndIsNoPartOfIt) {
  Matrix3d covariance = Correlated(0.1, 1.0, 0.1, 0.0);
  covariance(1, 1) = std::numeric_limits<double>::infinity();
  const OutputFit fit = FitAt({-0.5, 3.0, 0.0}, covariance);
  for (const LinearEstimate& e : IntegrateChanges(fit, Initial())) {
    EXPECT_EQ(e.change(1), 0.0);
    EXPECT_EQ(e.covariance(1, 1), covariance(1, 1));
    EXPECT_TRUE(e.change.allFinite());
  }
  OutputFit held = fit;
  held.free = {false};
  const std::vector<LinearEstimate> none = IntegrateChanges(held, Initial());
  ASSERT_EQ(none.size(), 1U);
  EXPECT_EQ(none[0].weight, 1.0);
  EXPECT_TRUE(none[0].change.isZero(0.0));
}

// Twenty elements of which one has changed: the search ends, and finds it.
TEST(ChangePriorTest, ManyElements) {
  constexpr int kElements = 20;
  OutputPoint initial;
  initial.values.assign(kElements, {2.0, 10.0, 2.0});
  initial.SetCells(0.5);
  OutputFit fit;
  fit.point = initial;
  fit.point.values[7].gain = 1.2;
  fit.free.assign(kElements, true);
  fit.covariance = MatrixXd::Zero(3 * kElements, 3 * kElements);
  fit.covariance.diagonal() =
      Vector3d(0.01, 0.25, 0.04).replicate(kElements, 1);
  fit.degrees_of_freedom = VectorXd::Constant(3 * kElements, 100.0);
  const std::vector<LinearEstimate> estimates = IntegrateChanges(fit, initial);
  double gain = 0.0;
  double other = 0.0;
  double weights = 0.0;
  for (const LinearEstimate& e : estimates) {
    gain += e.weight * e.change(21);
    other += e.weight * e.covariance(0, 0);
    weights += e.weight;
  }
  EXPECT_LE(estimates.size(), 64U);
  EXPECT_NEAR(weights, 1.0, 1e-12);
  EXPECT_NEAR(gain, 0.0, 0.1);
  EXPECT_LT(other, 0.5 * 0.01);
}

}  // namespace
}  // namespace mle
