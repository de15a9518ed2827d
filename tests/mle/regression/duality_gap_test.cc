#include "mle/regression/duality_gap.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "Eigen/QR"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {
namespace {

using MatrixXl = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using VectorXl = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

struct Values {
  long double primal = 0.0L;
  long double dual = 0.0L;
};

// Primal value of β and dual value of its scaled residual, from X and e, in
// long double:
//   D(θ) = (‖e‖² − ‖e − θ‖²) / 2N,  |x_j·θ|/N ≤ λw_j.
Values PrimalAndDual(const ExplicitLasso& problem, double lambda,
                     const Eigen::VectorXd& beta) {
  const MatrixXl X = problem.X.cast<long double>();
  const VectorXl e = problem.e.cast<long double>();
  const long double rows = static_cast<long double>(X.cols());
  VectorXl residual = e - X.transpose() * beta.cast<long double>();
  Values values;
  values.primal = residual.squaredNorm() / (2.0L * rows);
  std::vector<int> free;
  for (int j = 0; j < problem.size(); ++j) {
    const double w = problem.objective.weights(j);
    if (beta(j) != 0.0) {
      values.primal += static_cast<long double>(lambda) * w * std::abs(beta(j));
    }
    if (w == 0.0 || (lambda == 0.0 && std::isfinite(w))) free.push_back(j);
  }
  if (!free.empty()) {
    const MatrixXl F = X(free, Eigen::all).transpose();
    const Eigen::CompleteOrthogonalDecomposition<MatrixXl> solver(F);
    residual -= F * VectorXl(solver.solve(residual));
  }
  long double alpha = 1.0L;
  for (int j = 0; j < problem.size(); ++j) {
    const double w = problem.objective.weights(j);
    if (w == 0.0 || !std::isfinite(w) || lambda == 0.0) continue;
    const long double c = std::abs(X.row(j).dot(residual)) / rows;
    if (c > 0.0L) alpha = std::min(alpha, lambda * w / c);
  }
  values.dual =
      (e.squaredNorm() - (e - alpha * residual).squaredNorm()) / (2.0L * rows);
  return values;
}

Eigen::VectorXd RandomWeights(int n, std::mt19937_64& random) {
  Eigen::VectorXd weights(n);
  for (double& w : weights) w = 0.2 + static_cast<double>(random() % 30) / 10.0;
  return weights;
}

// Every term of the gap has been rounded relative to the moments' size, v.
constexpr double kGapTolerance = 1e-13;

TEST(DualityGapTest, IsPrimalLessDual) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    const int n = 1 + trial % 12;
    const int rows = 2 + trial % 17;
    Eigen::VectorXd weights = RandomWeights(n, random);
    if (trial % 3 == 1) weights(0) = 0.0;
    if (trial % 3 == 2 && n > 2) {
      weights(0) = 0.0;
      weights(1) = 0.0;
      weights(2) = kInfinity;
    }
    const ExplicitLasso problem(RandomMatrix(n, rows, random),
                                RandomVector(rows, random), weights);
    Eigen::VectorXd beta = 0.3 * RandomVector(n, random);
    for (int j = 0; j < n; ++j) {
      if (random() % 2 == 0 || !std::isfinite(weights(j))) beta(j) = 0.0;
    }
    for (const double lambda : {0.0, 1e-6, 0.01, 0.3, 10.0}) {
      const DualityGap gap = ComputeDualityGap(problem.objective, lambda, beta);
      const Values values = PrimalAndDual(problem, lambda, beta);
      const double scale = problem.objective.response_square +
                           static_cast<double>(values.primal);
      EXPECT_GE(gap.gap, 0.0);
      EXPECT_NEAR(gap.primal, static_cast<double>(values.primal),
                  kGapTolerance * scale);
      // The projection solves with a Gram matrix, of condition up to 1e4 here.
      EXPECT_NEAR(gap.gap, static_cast<double>(values.primal - values.dual),
                  1e4 * kGapTolerance * scale)
          << "λ = " << lambda << ", n = " << n << ", N = " << rows;
      EXPECT_EQ(gap.response_square, problem.objective.response_square);
    }
  }
}

// X Xᵀ/N = I: the solution is C shrunk by λw.
TEST(DualityGapTest, VanishesAtTheSolutionOfAnOrthonormalDesign) {
  std::mt19937_64 random(2);
  const int n = 12;
  const int rows = 30;
  const Eigen::MatrixXd Q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(RandomMatrix(rows, n, random))
          .householderQ() *
      Eigen::MatrixXd::Identity(rows, n);
  Eigen::VectorXd weights = RandomWeights(n, random);
  weights(3) = 0.0;
  weights(7) = kInfinity;
  const ExplicitLasso problem(std::sqrt(30.0) * Q.transpose(),
                              RandomVector(rows, random), weights);
  const Eigen::VectorXd& C = problem.objective.correlation;
  for (const double lambda : {1e-9, 1e-3, 0.05, 0.2, 5.0}) {
    Eigen::VectorXd beta(n);
    for (int j = 0; j < n; ++j) {
      const double size = std::max(std::abs(C(j)) - lambda * weights(j), 0.0);
      beta(j) = std::copysign(size, C(j));
    }
    const DualityGap gap = ComputeDualityGap(problem.objective, lambda, beta);
    // Rounding of c, 1e-16 of the size of C, relative to λ.
    EXPECT_LE(gap.Relative(), 1e-14 / std::min(lambda, 1.0)) << lambda;
    EXPECT_LE(gap.kkt_violation, 1e-14);
    // Moved off it, the gap is the loss and the violation the move.
    beta(3) += 0.01;
    const DualityGap off = ComputeDualityGap(problem.objective, lambda, beta);
    EXPECT_NEAR(off.gap, 0.5e-4, 1e-14);
    EXPECT_NEAR(off.kkt_violation, 0.01, 1e-14);
  }
}

// ½ cᵀG⁺c is the distance to the least-squares minimum, even where G is
// singular.
TEST(DualityGapTest, AtZeroIsTheDistanceToLeastSquares) {
  std::mt19937_64 random(3);
  Eigen::MatrixXd X = RandomMatrix(8, 20, random);
  X.row(5) = X.row(0) + X.row(1);
  X.row(6).setZero();
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(8);
  weights(7) = kInfinity;
  const ExplicitLasso problem(X, RandomVector(20, random), weights);
  const Eigen::VectorXd best = MinimumNormLeastSquares(problem.objective);
  EXPECT_EQ(best(7), 0.0);
  const double minimum = ComputeDualityGap(problem.objective, 0.0, best).primal;
  EXPECT_LE(ComputeDualityGap(problem.objective, 0.0, best).Relative(), 1e-13);
  // Of smallest norm: orthogonal to the null space.
  Eigen::VectorXd null = Eigen::VectorXd::Zero(8);
  null(0) = null(1) = 1.0;
  null(5) = -1.0;
  EXPECT_NEAR(best.dot(null), 0.0, 1e-13);
  for (int trial = 0; trial < 5; ++trial) {
    Eigen::VectorXd beta = RandomVector(8, random);
    beta(7) = 0.0;
    const DualityGap gap = ComputeDualityGap(problem.objective, 0.0, beta);
    EXPECT_NEAR(gap.gap, gap.primal - minimum, 1e-12 * gap.primal);
  }
}

TEST(DualityGapTest, ZeroIsExactFromLambdaMaxOn) {
  std::mt19937_64 random(4);
  const ExplicitLasso problem(RandomMatrix(5, 20, random),
                              RandomVector(20, random));
  const double lambda_max = problem.objective.LambdaMax();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(5);
  EXPECT_EQ(ComputeDualityGap(problem.objective, lambda_max, zero).gap, 0.0);
  EXPECT_EQ(ComputeDualityGap(problem.objective, 2 * lambda_max, zero).gap,
            0.0);
  EXPECT_GT(ComputeDualityGap(problem.objective, 0.9 * lambda_max, zero).gap,
            0.0);
}

// A perfect fit has a primal value of nothing but rounding; an empty problem
// none at all.
TEST(DualityGapTest, RelativeIsNeverNaN) {
  std::mt19937_64 random(5);
  const Eigen::MatrixXd X = RandomMatrix(3, 10, random);
  const Eigen::Vector3d beta(1.0, -2.0, 0.5);
  const ExplicitLasso exact(X, X.transpose() * beta);
  EXPECT_LE(ComputeDualityGap(exact.objective, 0.0, beta).Relative(), 1.0);
  const ExplicitLasso empty(X, Eigen::VectorXd::Zero(10));
  EXPECT_EQ(ComputeDualityGap(empty.objective, 0.0, Eigen::VectorXd::Zero(3))
                .Relative(),
            0.0);
  EXPECT_EQ(ComputeDualityGap(empty.objective, 1.0, Eigen::VectorXd::Zero(3))
                .Relative(),
            0.0);
}

// Large coefficients of nearly dependent regressors cancel: the primal value is
// a difference of products that exceed it, and is known to their rounding.
TEST(DualityGapTest, ThePrimalValueIsKnownToItsRounding) {
  std::mt19937_64 random(7);
  long double furthest_off = 0.0L;
  for (const double distance : {1.0, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    for (int trial = 0; trial < 20; ++trial) {
      Eigen::MatrixXd X = RandomMatrix(3, 30, random);
      const Eigen::VectorXd between = X.row(1);
      X.row(1) = X.row(0) + distance * between.transpose();
      const ExplicitLasso problem(X, between + 1e-6 * RandomVector(30, random),
                                  Eigen::Vector3d(0.0, 0.0, 1.0));
      const Eigen::Vector3d beta(-1.0 / distance, 1.0 / distance, 0.0);
      const DualityGap gap = ComputeDualityGap(problem.objective, 1e-9, beta);
      const Values exact = PrimalAndDual(problem, 1e-9, beta);
      EXPECT_LE(gap.primal - gap.primal_rounding, exact.primal) << distance;
      EXPECT_GE(gap.primal + gap.primal_rounding, exact.primal) << distance;
      EXPECT_GE(gap.Relative() * exact.primal, gap.gap) << distance;
      furthest_off = std::max(
          furthest_off, std::abs(gap.primal - exact.primal) / exact.primal);
    }
  }
  EXPECT_GT(furthest_off, 1.0L);
}

// A coefficient that is excluded may not differ from zero.
TEST(DualityGapTest, IsInfiniteWhereAnExcludedCoefficientIsUsed) {
  std::mt19937_64 random(6);
  const ExplicitLasso problem(RandomMatrix(2, 10, random),
                              RandomVector(10, random),
                              Eigen::Vector2d(1.0, kInfinity));
  for (const double lambda : {0.0, 0.1}) {
    const DualityGap gap =
        ComputeDualityGap(problem.objective, lambda, Eigen::Vector2d(0.0, 1.0));
    EXPECT_EQ(gap.gap, kInfinity);
    EXPECT_EQ(gap.Relative(), kInfinity);
  }
}

}  // namespace
}  // namespace mle
