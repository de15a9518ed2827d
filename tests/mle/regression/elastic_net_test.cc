#include "mle/regression/elastic_net.h"

#include <limits>
#include <random>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/regression/homotopy.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// Collinear: neighbouring columns are running means of the same noise.
ExplicitLasso CollinearProblem(int n, int rows, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd X = RandomMatrix(n, rows, random);
  for (int j = 1; j < n; ++j) X.row(j) = 0.95 * X.row(j - 1) + 0.1 * X.row(j);
  const Eigen::VectorXd e = X.transpose() * RandomMatrix(n, 1, random) +
                            0.1 * RandomMatrix(rows, 1, random);
  return ExplicitLasso(X, e);
}

Eigen::VectorXd Grid(double max, int count) {
  Eigen::VectorXd lambdas(count);
  for (int i = 0; i < count; ++i)
    lambdas(i) = max * std::pow(0.8, count - 1 - i);
  return lambdas;
}

TEST(ElasticNetTest, EverySolutionIsCertified) {
  const ExplicitLasso problem = CollinearProblem(40, 60, 1);
  const Eigen::VectorXd lambdas = Grid(problem.objective.LambdaMax(), 40);
  for (const double ratio : {0.1, 0.5, 0.9}) {
    const auto solution =
        SolveElasticNet(problem.objective, lambdas, {.ratio = ratio});
    ASSERT_TRUE(solution.ok()) << solution.status();
    EXPECT_LE(solution->MaxRelativeGap(), 1e-10) << "ratio " << ratio;
  }
}

// The conditions that a minimiser must meet, from explicit rows rather than the
// Gram matrix.
TEST(ElasticNetTest, MeetsOptimalityConditions) {
  const ExplicitLasso problem = CollinearProblem(25, 50, 2);
  const double rows = static_cast<double>(problem.X.cols());
  const double ratio = 0.4;
  const Eigen::VectorXd lambdas = Grid(problem.objective.LambdaMax(), 20);
  const auto solution =
      SolveElasticNet(problem.objective, lambdas, {.ratio = ratio});
  ASSERT_TRUE(solution.ok()) << solution.status();
  for (const double lambda : lambdas) {
    const Eigen::VectorXd beta = solution->path.Coefficients(lambda);
    const Eigen::VectorXd gradient =
        problem.X * (problem.e - problem.X.transpose() * beta) / rows -
        lambda * (1.0 - ratio) * beta;
    for (int j = 0; j < problem.size(); ++j) {
      // Rounding of sums of 50 products of size 1, relative to λ_max of size 1.
      const double tolerance = 1e-11;
      // At the end of its segment a zero is interpolated, and may be rounding.
      if (std::abs(beta(j)) < 1e-15) {
        EXPECT_LE(std::abs(gradient(j)), lambda * ratio + tolerance);
      } else {
        EXPECT_NEAR(gradient(j), std::copysign(lambda * ratio, beta(j)),
                    tolerance);
      }
    }
  }
}

// At λ_max/ρ; above it all are zero.
TEST(ElasticNetTest, PathBeginsWhereTheFirstCoefficientEnters) {
  const ExplicitLasso problem = CollinearProblem(25, 50, 6);
  const double ratio = 0.4;
  const double begin = problem.objective.LambdaMax() / ratio;
  const Eigen::Vector2d below(0.5 * begin, 0.999 * begin);
  const Eigen::Vector2d across(0.999 * begin, 1.001 * begin);
  const auto first =
      SolveElasticNet(problem.objective, below, {.ratio = ratio});
  const auto second =
      SolveElasticNet(problem.objective, across, {.ratio = ratio});
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(first->path.lambda_begin(), begin);
  EXPECT_TRUE(first->path.Coefficients(begin).isZero(0.0));
  EXPECT_FALSE(first->path.Coefficients(0.999 * begin).isZero(0.0));
  EXPECT_TRUE(second->path.Coefficients(1.001 * begin).isZero(0.0));
  EXPECT_FALSE(second->path.Coefficients(0.999 * begin).isZero(0.0));
}

TEST(ElasticNetTest, RatioOneIsTheLasso) {
  const ExplicitLasso problem = CollinearProblem(30, 60, 3);
  const Eigen::VectorXd lambdas = Grid(problem.objective.LambdaMax(), 20);
  const auto net = SolveElasticNet(problem.objective, lambdas, {.ratio = 1.0});
  const auto lasso = SolveHomotopy(problem.objective, {});
  ASSERT_TRUE(net.ok() && lasso.ok());
  for (const double lambda : lambdas) {
    const Eigen::VectorXd expected = lasso->path.Coefficients(lambda);
    const Eigen::VectorXd found = net->path.Coefficients(lambda);
    // Both solve systems of condition number about 1e5.
    EXPECT_LE((found - expected).norm(), 1e-9 * (1.0 + expected.norm()));
  }
}

// Columns that are alike share their coefficient, which the lasso need not do.
TEST(ElasticNetTest, SharesBetweenDuplicates) {
  std::mt19937_64 random(4);
  Eigen::MatrixXd X = RandomMatrix(6, 40, random);
  X.row(5) = X.row(0);
  const ExplicitLasso problem(
      X, 2.0 * X.row(0).transpose() + 0.1 * RandomMatrix(40, 1, random));
  const Eigen::VectorXd lambdas = Grid(problem.objective.LambdaMax(), 15);
  const auto solution =
      SolveElasticNet(problem.objective, lambdas, {.ratio = 0.5});
  ASSERT_TRUE(solution.ok()) << solution.status();
  for (const double lambda : lambdas) {
    const Eigen::VectorXd beta = solution->path.Coefficients(lambda);
    // The ridge of 0.5 λ ≥ 1e-2 tells them apart by rounding only.
    EXPECT_NEAR(beta(0), beta(5), 1e-12 * (1.0 + std::abs(beta(0))));
  }
}

// One orthonormal column: β = S(C, λρw) / (1 + λ(1 − ρ)).
TEST(ElasticNetTest, OneColumnInClosedForm) {
  const ExplicitLasso problem(Eigen::MatrixXd::Ones(1, 1),
                              Eigen::VectorXd::Constant(1, 3.0));
  Eigen::VectorXd lambdas(2);
  lambdas << 0.5, 2.0;
  const auto solution =
      SolveElasticNet(problem.objective, lambdas, {.ratio = 0.25});
  ASSERT_TRUE(solution.ok()) << solution.status();
  for (const double lambda : lambdas) {
    EXPECT_DOUBLE_EQ(solution->path.Coefficients(lambda)(0),
                     (3.0 - 0.25 * lambda) / (1.0 + 0.75 * lambda));
  }
}

TEST(ElasticNetTest, ExcludedAndUnpenalisedColumns) {
  ExplicitLasso problem = CollinearProblem(8, 30, 5);
  problem.objective.weights(2) = std::numeric_limits<double>::infinity();
  problem.objective.weights(5) = 0.0;
  const Eigen::VectorXd lambdas = Grid(problem.objective.LambdaMax(), 10);
  const auto solution =
      SolveElasticNet(problem.objective, lambdas, {.ratio = 0.5});
  ASSERT_TRUE(solution.ok()) << solution.status();
  EXPECT_LE(solution->MaxRelativeGap(), 1e-10);
  for (const double lambda : lambdas) {
    const Eigen::VectorXd beta = solution->path.Coefficients(lambda);
    EXPECT_EQ(beta(2), 0.0);
    EXPECT_NE(beta(5), 0.0);
  }
}

TEST(ElasticNetTest, RefusesBadInput) {
  const ExplicitLasso problem = CollinearProblem(3, 10, 6);
  const Eigen::VectorXd lambdas = Eigen::VectorXd::Constant(1, 0.1);
  const auto message = [&](const Eigen::VectorXd& grid, double ratio) {
    return std::string(
        SolveElasticNet(problem.objective, grid, {.ratio = ratio})
            .status()
            .message());
  };
  EXPECT_THAT(message(lambdas, 0.0), HasSubstr("ratio is 0"));
  EXPECT_THAT(message(lambdas, 1.5), HasSubstr("ratio is 1.5"));
  EXPECT_THAT(message({}, 0.5), HasSubstr("empty"));
  EXPECT_THAT(message(-lambdas, 0.5), HasSubstr("-0.1"));
}

}  // namespace
}  // namespace mle
