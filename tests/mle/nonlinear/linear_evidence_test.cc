#include "mle/nonlinear/linear_evidence.h"

#include <cmath>
#include <random>

#include "Eigen/Dense"
#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRows = 40;
constexpr int kColumns = 5;

struct Problem {
  MatrixXd X = MatrixXd(kRows, kColumns);
  VectorXd e = VectorXd(kRows);
  LinearPrior prior;
};

Problem MakeProblem() {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  Problem problem;
  for (double& value : problem.X.reshaped()) value = normal(engine);
  for (double& value : problem.e) value = normal(engine);
  problem.e += problem.X * VectorXd::LinSpaced(kColumns, -1.0, 2.0);
  problem.prior.means = VectorXd::LinSpaced(kColumns, 0.3, -0.4);
  // One coefficient stands at its mean.
  problem.prior.variances.resize(kColumns);
  problem.prior.variances << 1.0, 0.0, 4.0, 1e-4, 0.3;
  return problem;
}

// The normal density of e itself, its covariance written out.
double DenseDeviance(const Problem& problem, double variance) {
  const MatrixXd covariance =
      variance * MatrixXd::Identity(kRows, kRows) +
      problem.X * problem.prior.variances.asDiagonal() * problem.X.transpose();
  const VectorXd left = problem.e - problem.X * problem.prior.means;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance);
  return eigen.eigenvalues().array().log().sum() +
         left.dot(covariance.ldlt().solve(left));
}

TEST(LinearEvidenceTest, IsTheDensityOfTheData) {
  const Problem problem = MakeProblem();
  const LinearEvidence evidence(problem.X, problem.e, kRows, 0.0);
  for (const double variance : {0.1, 1.0, 30.0}) {
    EXPECT_NEAR(evidence.Deviance(problem.prior, variance),
                DenseDeviance(problem, variance), 1e-8);
    EXPECT_NEAR(evidence.Posterior(problem.prior, variance).deviance,
                DenseDeviance(problem, variance), 1e-8);
  }
}

TEST(LinearEvidenceTest, PosteriorIsThatOfTheJointDensity) {
  const Problem problem = MakeProblem();
  const double variance = 0.7;
  const LinearPosterior posterior =
      LinearEvidence(problem.X, problem.e, kRows, 5.0)
          .Posterior(problem.prior, variance);
  const MatrixXd D = problem.prior.variances.asDiagonal();
  const MatrixXd covariance = variance * MatrixXd::Identity(kRows, kRows) +
                              problem.X * D * problem.X.transpose();
  const MatrixXd gain = D * problem.X.transpose() * covariance.inverse();
  const VectorXd means = problem.prior.means +
                         gain * (problem.e - problem.X * problem.prior.means);
  EXPECT_LT((posterior.means - means).norm(), 1e-10);
  EXPECT_LT((posterior.covariance - (D - gain * problem.X * D)).norm(), 1e-10);
  EXPECT_EQ(posterior.means(1), problem.prior.means(1));
  EXPECT_EQ(posterior.covariance(1, 1), 0.0);
}

// At its fixed point the noise variance maximises the evidence.
TEST(LinearEvidenceTest, NoiseVarianceMovesToTheMaximum) {
  const Problem problem = MakeProblem();
  const LinearEvidence evidence(problem.X, problem.e, kRows, 0.0);
  double variance = 20.0;
  for (int i = 0; i < 200; ++i) {
    variance = evidence.Posterior(problem.prior, variance).next_noise_variance;
  }
  const double best = evidence.Deviance(problem.prior, variance);
  EXPECT_GT(evidence.Deviance(problem.prior, 1.05 * variance), best);
  EXPECT_GT(evidence.Deviance(problem.prior, variance / 1.05), best);
}

TEST(LinearEvidenceTest, WithoutFreeCoefficientsItIsThatOfTheNoise) {
  Problem problem = MakeProblem();
  problem.prior.variances.setZero();
  const LinearEvidence evidence(problem.X, problem.e, kRows, 0.0);
  EXPECT_NEAR(evidence.Deviance(problem.prior, 2.0),
              DenseDeviance(problem, 2.0), 1e-9);
}

}  // namespace
}  // namespace mle
