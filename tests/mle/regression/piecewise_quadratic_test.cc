#include "mle/regression/piecewise_quadratic.h"

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

// Continuous, with random pieces from a random knot down to `end`.
PiecewiseQuadratic RandomFunction(double end, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const int count = 1 + static_cast<int>(random() % 12);
  std::vector<double> knots;
  for (int i = 0; i < count; ++i) knots.push_back(2.0 + uniform(random));
  std::sort(knots.rbegin(), knots.rend());
  knots.push_back(end);
  double value = uniform(random);
  PiecewiseQuadratic function(value);
  for (int i = 0; i < count; ++i) {
    const PiecewiseQuadratic::Piece piece{knots[i], knots[i + 1], value,
                                          3.0 * uniform(random),
                                          2.0 * uniform(random)};
    function.Append(piece);
    value = piece.At(piece.lambda_end);
  }
  return function;
}

TEST(PiecewiseQuadraticTest, IsItsPieces) {
  PiecewiseQuadratic f(7.0);
  EXPECT_EQ(f(0.0), 7.0);
  EXPECT_EQ(f(5.0), 7.0);
  f.Append({4.0, 2.0, 7.0, -1.0, 0.5});  // 7 − t + t²/2
  f.Append({2.0, 1.0, 7.0, 2.0, 0.0});   // 7 + 2t
  EXPECT_EQ(f(5.0), 7.0);
  EXPECT_EQ(f(4.0), 7.0);
  EXPECT_EQ(f(3.0), 6.5);
  EXPECT_EQ(f(2.0), 7.0);
  EXPECT_EQ(f(1.5), 8.0);
  EXPECT_EQ(f(1.0), 9.0);
  EXPECT_EQ(f(0.0), 9.0);  // constant below its end
}

TEST(PiecewiseQuadraticTest, TakesTheLaterPieceWhereTwoMeet) {
  PiecewiseQuadratic f(0.0);
  f.Append({4.0, 2.0, 7.0, -1.0, 0.5});
  f.Append({2.0, 1.0, 7.25, 2.0, 0.0});  // as if by rounding
  EXPECT_EQ(f(2.0), 7.25);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(1);
  f.AddTo(Eigen::VectorXd::Constant(1, 2.0), sums);
  EXPECT_EQ(sums(0), 7.25);
}

TEST(PiecewiseQuadraticTest, OneSweepGivesTheValuesOneByOne) {
  std::mt19937_64 random(1);
  for (const double end : {0.0, 0.5}) {
    const PiecewiseQuadratic f = RandomFunction(end, random);
    std::vector<double> points = {0.0, 4.0};
    for (const auto& piece : f.pieces()) points.push_back(piece.lambda_begin);
    for (int i = 0; i < 200; ++i) points.push_back(i * 0.017);
    std::sort(points.begin(), points.end());
    const Eigen::VectorXd lambdas = Eigen::Map<Eigen::VectorXd>(
        points.data(), static_cast<Eigen::Index>(points.size()));
    Eigen::VectorXd sums = Eigen::VectorXd::Constant(lambdas.size(), 10.0);
    f.AddTo(lambdas, sums);
    for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
      EXPECT_NEAR(sums(i), 10.0 + f(lambdas(i)), 1e-13) << lambdas(i);
    }
  }
  Eigen::VectorXd sums = Eigen::Vector2d::Zero();
  PiecewiseQuadratic(3.0).AddTo(Eigen::Vector2d(0.0, 1.0), sums);
  EXPECT_EQ(sums, Eigen::Vector2d(3.0, 3.0));
}

// No point of a dense grid is lower, and one comes close: with a curvature of
// at most 4·3 functions, half a grid step off the vertex costs 6 h².
TEST(MinimizeSumTest, IsTheLeastOfADenseGrid) {
  std::mt19937_64 random(2);
  constexpr double kStep = 1e-4;
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<PiecewiseQuadratic> functions;
    for (int i = 0; i <= trial % 3; ++i) {
      functions.push_back(RandomFunction(trial % 2 == 0 ? 0.0 : 0.3, random));
    }
    const Minimum minimum = MinimizeSum(functions);
    const auto sum_at = [&](double lambda) {
      double sum = 0.0;
      for (const auto& f : functions) sum += f(lambda);
      return sum;
    };
    double least = std::numeric_limits<double>::infinity();
    for (double lambda = 0.0; lambda < 3.2; lambda += kStep) {
      least = std::min(least, sum_at(lambda));
    }
    EXPECT_DOUBLE_EQ(minimum.value, sum_at(minimum.lambda));
    EXPECT_LE(minimum.value, least + 1e-14);
    // Or a knot, where a slope of up to 3·(3 + 4·3) meets the grid.
    EXPECT_GE(minimum.value, least - 45.0 * kStep);
    EXPECT_GE(minimum.lambda, 0.0);
  }
}

TEST(MinimizeSumTest, FindsAVertexExactly) {
  // (λ − 0.7)² + 1 on [0, 2].
  PiecewiseQuadratic f(2.69);
  f.Append({2.0, 0.0, 2.69, -2.6, 1.0});
  const Minimum minimum = MinimizeSum({&f, 1});
  EXPECT_NEAR(minimum.lambda, 0.7, 1e-14);
  EXPECT_NEAR(minimum.value, 1.0, 1e-14);
}

TEST(MinimizeSumTest, TakesTheLargestOfEqualMinima) {
  // Flat at 1 from 3 down to 2, then rising.
  PiecewiseQuadratic f(1.0);
  f.Append({3.0, 2.0, 1.0, 0.0, 0.0});
  f.Append({2.0, 0.0, 1.0, 1.0, 0.0});
  EXPECT_EQ(MinimizeSum({&f, 1}).lambda, 3.0);
  EXPECT_EQ(MinimizeSum({&f, 1}).value, 1.0);
  // Nothing but constants.
  const PiecewiseQuadratic constant(4.0);
  EXPECT_EQ(MinimizeSum({&constant, 1}).lambda, 0.0);
  EXPECT_EQ(MinimizeSum({&constant, 1}).value, 4.0);
}

}  // namespace
}  // namespace mle
