#include "sim/runge_kutta.h"

#include <cmath>

#include "Eigen/Core"
#include "gtest/gtest.h"

namespace mle::sim {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// A nonlinear pendulum without friction.
void Pendulum(const Vector2d& x, Vector2d& dx) { dx << x[1], -std::sin(x[0]); }

Vector2d Integrate(const Vector2d& start, double duration, int steps) {
  Vector2d x = start;
  RungeKutta4<Vector2d> scheme(x);
  for (int i = 0; i < steps; ++i) scheme.Step(Pendulum, duration / steps, x);
  return x;
}

TEST(RungeKutta4Test, StepOnALinearProblemIsTheTaylorPolynomial) {
  Eigen::VectorXd x = Eigen::VectorXd::Constant(1, 2.0);
  RungeKutta4<Eigen::VectorXd> scheme(x);
  const double h = 0.7;
  const auto decay = [](const Eigen::VectorXd& at, Eigen::VectorXd& dx) {
    dx = -at;
  };
  scheme.Step(decay, h, x);
  const double taylor =
      1.0 - h + h * h / 2.0 - h * h * h / 6.0 + h * h * h * h / 24.0;
  EXPECT_NEAR(x[0], 2.0 * taylor, 1e-15);
}

TEST(RungeKutta4Test, ConvergesWithOrderFourOnANonlinearProblem) {
  const Vector2d start(1.5, 0.2);
  const Vector2d limit = Integrate(start, 4.0, 1 << 14);
  double previous = 0.0;
  for (int steps = 32; steps <= 256; steps *= 2) {
    const double error = (Integrate(start, 4.0, steps) - limit).norm();
    // The next term of the error is a step length smaller.
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / error), 4.0, 0.2);
    }
    previous = error;
  }
}

TEST(RungeKutta4Test, KeepsTheEnergyOfThePendulumToTheFourthOrder) {
  const auto energy = [](const Vector2d& x) {
    return 0.5 * x[1] * x[1] - std::cos(x[0]);
  };
  const Vector2d start(1.0, 0.0);
  // h = 0.01: h⁴ = 1e-8, times a constant below one for the whole 10 units.
  EXPECT_NEAR(energy(Integrate(start, 10.0, 1000)), energy(start), 1e-8);
}

TEST(RungeKutta4Test, ColumnsAreTrajectoriesOfTheirOwn) {
  Matrix2d A;
  A << -1.0, 0.3, 0.5, -2.0;
  const auto matrix_field = [&A](const Matrix2d& x, Matrix2d& dx) {
    dx = A * x;
  };
  const auto vector_field = [&A](const Vector2d& x, Vector2d& dx) {
    dx = A * x;
  };
  Matrix2d both;
  both << 1.0, -3.0, 0.5, 2.0;
  Vector2d second = both.col(1);
  RungeKutta4<Matrix2d>(both).Step(matrix_field, 0.1, both);
  RungeKutta4<Vector2d>(second).Step(vector_field, 0.1, second);
  EXPECT_NEAR((both.col(1) - second).norm(), 0.0, 1e-15);
}

}  // namespace
}  // namespace mle::sim
