#include "mle/nonlinear/box_least_squares.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd RandomMatrix(int rows, int cols, std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(engine); });
}

// A minimum within bounds is where the slope is zero between them and points
// outwards at them.
TEST(MinimiseQuadraticTest, MeetsTheConditionsOfAMinimum) {
  std::mt19937_64 engine(1);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + trial % 40;
    const MatrixXd J = RandomMatrix(n + 3, n, engine);
    const MatrixXd H = J.transpose() * J;
    const VectorXd g = RandomMatrix(n, 1, engine) * n;
    VectorXd lower = -RandomMatrix(n, 1, engine).cwiseAbs();
    VectorXd upper = RandomMatrix(n, 1, engine).cwiseAbs();
    if (trial % 3 == 0) lower(0) = upper(0);
    if (trial % 4 == 0) upper(n - 1) = kInfinity;
    const VectorXd d = MinimiseQuadratic(H, g, lower, upper);
    const VectorXd slope = H * d + g;
    const double small = 1e-9 * (H.norm() + g.norm());
    for (int i = 0; i < n; ++i) {
      EXPECT_GE(d(i), lower(i));
      EXPECT_LE(d(i), upper(i));
      if (d(i) > lower(i)) {
        EXPECT_LT(slope(i), small) << trial;
      }
      if (d(i) < upper(i)) {
        EXPECT_GT(slope(i), -small) << trial;
      }
    }
  }
}

// r = (10 (x₂ − x₁²), 1 − x₁): Rosenbrock's valley, least at (1, 1).
QuadraticModel Valley(const VectorXd& x) {
  const VectorXd r =
      (VectorXd(2) << 10.0 * (x(1) - x(0) * x(0)), 1.0 - x(0)).finished();
  const MatrixXd J =
      (MatrixXd(2, 2) << -20.0 * x(0), 10.0, -1.0, 0.0).finished();
  return {.cost = 0.5 * r.squaredNorm(),
          .gradient = J.transpose() * r,
          .hessian = J.transpose() * J};
}

TEST(MinimiseWithinBoxTest, FindsAMinimumBetweenTheBounds) {
  VectorXd x = (VectorXd(2) << -1.2, 1.0).finished();
  const VectorXd bound = VectorXd::Constant(2, 10.0);
  const BoxLeastSquaresSummary summary =
      MinimiseWithinBox(Valley, -bound, bound, {}, x);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.iterations, 60);
  EXPECT_LT((x - VectorXd::Ones(2)).norm(), 1e-6);
}

// With x₁ ≤ ½ the least of (1 − x₁)² along the valley is at x₁ = ½, x₂ = ¼.
TEST(MinimiseWithinBoxTest, FindsAMinimumAtABound) {
  VectorXd x = (VectorXd(2) << 3.0, 1.0).finished();  // outside
  const VectorXd lower = VectorXd::Constant(2, -kInfinity);
  const VectorXd upper = (VectorXd(2) << 0.5, kInfinity).finished();
  const BoxLeastSquaresSummary summary =
      MinimiseWithinBox(Valley, lower, upper, {}, x);
  EXPECT_TRUE(summary.converged);
  EXPECT_EQ(x(0), 0.5);
  EXPECT_NEAR(x(1), 0.25, 1e-9);
  EXPECT_NEAR(summary.cost, 0.125, 1e-12);
}

// Where residuals are linear a step ends it, whatever the bounds.
TEST(MinimiseWithinBoxTest, LinearResidualsTakeFewSteps) {
  std::mt19937_64 engine(2);
  const MatrixXd J = RandomMatrix(30, 12, engine);
  const VectorXd y = 3.0 * RandomMatrix(30, 1, engine);
  int evaluations = 0;
  const auto evaluate = [&](const VectorXd& x) {
    ++evaluations;
    const VectorXd r = J * x - y;
    return QuadraticModel{.cost = 0.5 * r.squaredNorm(),
                          .gradient = J.transpose() * r,
                          .hessian = J.transpose() * J};
  };
  VectorXd x = VectorXd::Zero(12);
  const VectorXd bound = VectorXd::Constant(12, 0.3);
  EXPECT_TRUE(MinimiseWithinBox(evaluate, -bound, bound, {}, x).converged);
  EXPECT_LE(evaluations, 4);
  EXPECT_GT((x.array().abs() == 0.3).count(), 0);
}

// r = atan x: from afar Gauss's and Newton's steps go farther away at every
// turn. Whenever it has to stop, no evaluation was better than its answer.
TEST(MinimiseWithinBoxTest, TakesNoStepThatIsWorse) {
  const VectorXd bound = VectorXd::Constant(1, 1e6);
  for (int most = 1; most <= 30; ++most) {
    double least = kInfinity;
    const auto evaluate = [&least](const VectorXd& x) {
      const double r = std::atan(x(0));
      const double slope = 1.0 / (1.0 + x(0) * x(0));
      const double cost = 0.5 * r * r;
      least = std::min(least, cost);
      return QuadraticModel{.cost = cost,
                            .gradient = VectorXd::Constant(1, slope * r),
                            .hessian = MatrixXd::Constant(1, 1, slope * slope)};
    };
    VectorXd x = VectorXd::Constant(1, 3.0);
    const BoxLeastSquaresSummary summary =
        MinimiseWithinBox(evaluate, -bound, bound, {.max_iterations = most}, x);
    EXPECT_LE(summary.cost, least) << most;
    EXPECT_LE(std::abs(x(0)), 3.0) << most;
    EXPECT_TRUE(summary.converged || most < 30) << most;
  }
}

TEST(MinimiseWithinBoxTest, SaysWhereItDidNotConverge) {
  VectorXd x = (VectorXd(2) << -1.2, 1.0).finished();
  const VectorXd bound = VectorXd::Constant(2, 10.0);
  EXPECT_FALSE(
      MinimiseWithinBox(Valley, -bound, bound, {.max_iterations = 2}, x)
          .converged);
  const auto fault = [](const VectorXd& at) {
    QuadraticModel model = Valley(at);
    model.cost = std::numeric_limits<double>::quiet_NaN();
    return model;
  };
  const BoxLeastSquaresSummary summary =
      MinimiseWithinBox(fault, -bound, bound, {}, x);
  EXPECT_FALSE(summary.converged);
  EXPECT_FALSE(std::isfinite(summary.cost));
}

}  // namespace
}  // namespace mle
