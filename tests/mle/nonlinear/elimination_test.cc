#include "mle/nonlinear/elimination.h"

#include <cmath>
#include <random>

#include "Eigen/LU"
#include "Eigen/QR"
#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd RandomColumns(Index rows, Index cols) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  MatrixXd matrix(rows, cols);
  for (double& value : matrix.reshaped()) value = normal(engine);
  return matrix;
}

// Column 2 depends on two others, column 4 is zero; scales differ by 1e12.
MatrixXd DependentColumns() {
  MatrixXd columns = RandomColumns(40, 8);
  columns.col(2) = columns.col(0) - 0.5 * columns.col(1);
  columns.col(4).setZero();
  columns.col(0) *= 1e6;
  columns.col(3) *= 1e-6;
  return columns;
}

constexpr Index kTaken = 5;  // of which three are independent

TEST(Elimination, LeavesWhatTheColumnsDoNotExplain) {
  const MatrixXd columns = DependentColumns();
  const Elimination elimination =
      EliminateFirst(kTaken, columns.transpose() * columns);
  EXPECT_EQ(elimination.rank(), 3);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> qr;
  qr.setThreshold(1e-9);
  // Columns of one length: dependence does not know scales.
  const VectorXd norms = columns.leftCols(kTaken).colwise().norm();
  qr.compute(columns.leftCols(kTaken) *
             norms.cwiseMax(1e-300).cwiseInverse().asDiagonal());
  const MatrixXd others = columns.rightCols(3);
  const MatrixXd basis = qr.householderQ() * MatrixXd::Identity(40, qr.rank());
  const MatrixXd left = others - basis * (basis.transpose() * others);
  EXPECT_LT((elimination.rest - left.transpose() * left).norm(), 1e-10);
}

TEST(Elimination, RowsAndRestHaveTheSameProducts) {
  const MatrixXd columns = DependentColumns();
  const MatrixXd products = columns.transpose() * columns;
  const Elimination elimination = EliminateFirst(kTaken, products);
  MatrixXd expected = elimination.rows.transpose() * elimination.rows;
  expected.bottomRightCorner(3, 3) += elimination.rest;
  const VectorXd scales =
      products.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  EXPECT_LT((scales.asDiagonal() * (expected - products) * scales.asDiagonal())
                .norm(),
            1e-12);
  const MatrixXd pivots = products(elimination.pivots, elimination.pivots);
  EXPECT_NEAR(elimination.log_determinant, std::log(pivots.determinant()),
              1e-9);
}

TEST(Elimination, CoefficientsAreThoseOfLeastSquares) {
  const MatrixXd columns = DependentColumns();
  const Elimination elimination =
      EliminateFirst(kTaken, columns.transpose() * columns);
  for (const Index b : {5, 6, 7}) {
    const VectorXd coefficients = elimination.Coefficients(b);
    ASSERT_EQ(coefficients.size(), kTaken);
    EXPECT_EQ(coefficients(4), 0.0);
    const VectorXd left =
        columns.col(b) - columns.leftCols(kTaken) * coefficients;
    for (Index j = 0; j < kTaken; ++j) {
      EXPECT_LT(std::abs(columns.col(j).dot(left)),
                1e-9 * columns.col(j).norm() + 1e-15);
    }
  }
}

// What rounding leaves of a dependent column is no column.
TEST(Elimination, RoundingIsNoRank) {
  const MatrixXd columns = RandomColumns(50, 31);
  for (Index i = 0; i + 1 < columns.cols(); ++i) {
    MatrixXd twins(50, 3);
    twins.col(0) = columns.col(i);
    twins.col(1) = 3.0 * columns.col(i) + 1e-9 * columns.col(i + 1);
    twins.col(2) = columns.col(30);
    const Elimination elimination =
        EliminateFirst(2, twins.transpose() * twins);
    EXPECT_EQ(elimination.rank(), 1) << i;
    EXPECT_EQ(elimination.Coefficients(2).array().abs().minCoeff(), 0.0) << i;
  }
}

TEST(Elimination, OfNoColumnsLeavesAll) {
  const MatrixXd columns = RandomColumns(10, 3);
  const MatrixXd products = columns.transpose() * columns;
  const Elimination elimination = EliminateFirst(0, products);
  EXPECT_EQ(elimination.rank(), 0);
  EXPECT_EQ(elimination.rest, products);
  EXPECT_EQ(elimination.log_determinant, 0.0);
}

}  // namespace
}  // namespace mle
