#include "apps/watch/packed_score.h"

#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "gtest/gtest.h"
#include "mle/base/random.h"

namespace mle::watch {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// V = J Jᵀ and S = J ν of `rank` independent samples, in units that differ by
// powers of ten.
ScorePart MakePart(int n, int rank) {
  GaussianNoise noise(7, kRunStream);
  VectorXd units(n);
  for (int a = 0; a < n; ++a) units(a) = std::pow(10.0, a % 5 - 2);
  const MatrixXd sensitivities =
      units.asDiagonal() * noise.DrawMatrix(n, rank, 1.0);
  return {sensitivities * noise.DrawMatrix(rank, 1, 1.0),
          sensitivities * sensitivities.transpose()};
}

ScorePart Kept(const ScorePart& part) {
  const auto n = static_cast<std::size_t>(part.score.size());
  std::string bytes;
  Pack(part, bytes);
  EXPECT_EQ(bytes.size(), PackedSize(n));
  return Unpack(n, bytes);
}

MatrixXd FactorOf(const ScorePart& part) {
  return part.information.llt().matrixL();
}

TEST(PackedScoreTest, EachParameterIsKeptToThreeDigitsOfItsOwn) {
  const ScorePart part = MakePart(12, 40);
  const ScorePart kept = Kept(part);
  for (int a = 0; a < 12; ++a) {
    const double scale = std::sqrt(part.information(a, a));
    EXPECT_NEAR(kept.score(a), part.score(a), 2e-3 * scale);
    for (int b = 0; b < 12; ++b) {
      EXPECT_NEAR(kept.information(a, b), part.information(a, b),
                  1e-3 * scale * std::sqrt(part.information(b, b)));
    }
  }
}

// The bounds of the header: of pivots and of the numbers beside them.
TEST(PackedScoreTest, TheFactorIsKeptWithinItsBounds) {
  const ScorePart part = MakePart(12, 40);
  const MatrixXd error = FactorOf(Kept(part)) - FactorOf(part);
  for (int a = 0; a < 12; ++a) {
    const double scale = std::sqrt(part.information(a, a));
    EXPECT_LE(std::abs(error(a, a)), std::ldexp(scale, -14));
    for (int c = 0; c < a; ++c) EXPECT_LE(std::abs(error(a, c)), 5e-4 * scale);
  }
}

// After a change δ of one parameter the score is Vδ: what is kept says that
// change, and of all others no more than 0.05 % of the standard deviations that
// it is seen with.
TEST(PackedScoreTest, AChangeIsTakenForAnotherWithinTheBound) {
  for (int a = 0; a < 12; ++a) {
    ScorePart part = MakePart(12, 14);
    part.score = part.information.col(a);
    const double seen = std::sqrt(part.information(a, a));
    const ScorePart kept = Kept(part);
    const MatrixXd factor = FactorOf(kept);
    const VectorXd whitened =
        factor.triangularView<Eigen::Lower>().solve(kept.score);
    const VectorXd taken_for = factor.transpose().col(a);
    // And the rounding of z itself.
    EXPECT_LE((whitened - taken_for).cwiseAbs().maxCoeff(), 6e-4 * seen) << a;
  }
}

// Two parameters that can hardly be told apart: what the rounding moves does
// not become a difference of them.
TEST(PackedScoreTest, WhatTheScoreSaysOfNearlyCollinearParametersIsKept) {
  for (const double apart : {0.1, 0.01, 0.001}) {
    const MatrixXd factor{
        {1.0, 0.0, 0.0}, {0.36, 0.93, 0.0}, {0.71357, 0.7005, apart}};
    const VectorXd whitened{{3.0, -2.0, 0.5}};
    const ScorePart kept =
        Kept({factor * whitened, factor * factor.transpose()});
    EXPECT_NEAR(kept.score.dot(kept.information.ldlt().solve(kept.score)),
                whitened.squaredNorm(), 1e-3)
        << apart;
  }
}

// What a score says where nothing has changed is SᵀV⁺S.
TEST(PackedScoreTest, WhatTheScoreSaysIsKept) {
  const ScorePart part = MakePart(6, 30);
  const ScorePart kept = Kept(part);
  const double before =
      part.score.dot(part.information.ldlt().solve(part.score));
  const double after =
      kept.score.dot(kept.information.ldlt().solve(kept.score));
  EXPECT_NEAR(after, before, 1e-3 * before);
}

TEST(PackedScoreTest, InformationOfLowRankStaysPositiveAndExplainsTheScore) {
  const ScorePart part = MakePart(12, 4);
  const ScorePart kept = Kept(part);
  const VectorXd scale = part.information.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled =
      scale.asDiagonal() * kept.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scaled);
  EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-12);
  const MatrixXd& vectors = solver.eigenvectors();
  const VectorXd score = scale.asDiagonal() * kept.score;
  // Eight directions say nothing, and the score has nothing in them.
  EXPECT_LT(solver.eigenvalues()(7), 1e-6);
  EXPECT_LT((vectors.leftCols(8).transpose() * score).norm(),
            1e-3 * score.norm());
}

TEST(PackedScoreTest, WhatWasPackedDoesNotChange) {
  for (const int rank : {4, 12, 50}) {
    std::string once;
    Pack(MakePart(12, rank), once);
    std::string twice;
    Pack(Unpack(12, once), twice);
    EXPECT_EQ(once, twice) << "rank " << rank;
  }
}

TEST(PackedScoreTest, NothingIsNothing) {
  const ScorePart kept = Kept({VectorXd::Zero(3), MatrixXd::Zero(3, 3)});
  EXPECT_EQ(kept.score, VectorXd::Zero(3));
  EXPECT_EQ(kept.information, MatrixXd::Zero(3, 3));
}

}  // namespace
}  // namespace mle::watch
