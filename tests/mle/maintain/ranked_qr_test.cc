#include "mle/maintain/ranked_qr.h"

#include <random>

#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd RandomColumns(int rows, int columns) {
  std::mt19937_64 source(3);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(source); });
}

// Of more columns than Eigen's blocks hold, twins among them, and of fewer rows
// than columns: orthonormal, and all of each column is in their span.
TEST(RankedQrTest, TheBasisSpansTheColumns) {
  for (const int rows : {300, 40}) {
    MatrixXd columns = RandomColumns(rows, 70);
    for (int j = 0; j < 70; j += 7) columns.col(j) = -2.0 * columns.col(j + 1);
    const RankedQr qr(columns, 1e-7);
    ASSERT_EQ(qr.rank(), rows == 300 ? 60 : 40);
    const MatrixXd basis = qr.Basis();
    EXPECT_LT(
        (basis.transpose() * basis - MatrixXd::Identity(qr.rank(), qr.rank()))
            .norm(),
        1e-12);
    EXPECT_LT((columns - basis * (basis.transpose() * columns)).norm(), 1e-10);
    const VectorXd other = RandomColumns(rows, 71).col(70);
    EXPECT_NEAR(qr.SquaresLeft(other),
                (other - basis * (basis.transpose() * other)).squaredNorm(),
                1e-10);
    EXPECT_LT(qr.SquaresLeft(columns.col(0)), 1e-20 * rows);
  }
}

// A difference below the threshold is none.
TEST(RankedQrTest, TheThresholdDecidesOfTwins) {
  MatrixXd columns = RandomColumns(100, 3);
  columns.col(1) = columns.col(0) + 1e-6 * columns.col(2);
  const MatrixXd twins = columns.leftCols(2);
  EXPECT_EQ(RankedQr(twins, 1e-7).rank(), 2);
  EXPECT_EQ(RankedQr(twins, 1e-4).rank(), 1);
  EXPECT_EQ(RankedQr(MatrixXd::Zero(50, 2), 1e-7).rank(), 0);
}

}  // namespace
}  // namespace mle
