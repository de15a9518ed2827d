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

TEST(PackedScoreTest, EachParameterIsKeptToFourDigitsOfItsOwn) {
  const ScorePart part = MakePart(12, 40);
  const ScorePart kept = Kept(part);
  for (int a = 0; a < 12; ++a) {
    const double scale = std::sqrt(part.information(a, a));
    EXPECT_NEAR(kept.score(a), part.score(a), 3e-4 * scale);
    for (int b = 0; b < 12; ++b) {
      EXPECT_NEAR(kept.information(a, b), part.information(a, b),
                  2e-4 * scale * std::sqrt(part.information(b, b)));
    }
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
