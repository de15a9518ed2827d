#include "mle/regression/updatable_cholesky.h"

#include <random>
#include <vector>

#include "Eigen/Cholesky"
#include "gtest/gtest.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {
namespace {

// The factor under test with the list of columns it should stand for.
class Tracked {
 public:
  Tracked(const Eigen::MatrixXd& gram, int capacity)
      : gram_(gram), cholesky_(capacity) {}

  const std::vector<int>& columns() const { return columns_; }
  UpdatableCholesky& cholesky() { return cholesky_; }

  double Append(int column, double tolerance) {
    const Eigen::VectorXd cross = gram_.col(column)(columns_);
    const int before = cholesky_.size();
    const double pivot =
        cholesky_.Append(cross, gram_(column, column), tolerance);
    if (cholesky_.size() == before) return pivot;
    columns_.push_back(column);
    // Its number, as anything that tells columns apart.
    const double target = column + 1.0;
    Eigen::VectorXd half(cholesky_.size());
    half << half_, cholesky_.LastOfHalf(half_, target);
    half_ = half;
    return pivot;
  }

  void Remove(int position) {
    cholesky_.Remove(position, half_);
    half_.conservativeResize(cholesky_.size());
    columns_.erase(columns_.begin() + position);
  }

  // Solves as Eigen does. Both are backward stable: the solutions differ by
  // cond(G) ε at most, times the few hundred updates.
  void ExpectRight(std::mt19937_64& random) {
    ASSERT_EQ(cholesky_.size(), static_cast<int>(columns_.size()));
    const Eigen::MatrixXd gram = gram_(columns_, columns_);
    const Eigen::VectorXd x =
        RandomVector(static_cast<Eigen::Index>(columns_.size()), random);
    Eigen::VectorXd solved = x;
    cholesky_.SolveInPlace(solved);
    const Eigen::VectorXd expected = gram.llt().solve(x);
    EXPECT_LE((solved - expected).norm(), 1e-9 * expected.norm());
    EXPECT_NEAR(cholesky_.InverseQuadraticForm(x), x.dot(expected),
                1e-9 * x.dot(expected));
    // The right-hand side that is carried along.
    Eigen::VectorXd target(columns_.size());
    for (Eigen::Index i = 0; i < target.size(); ++i) {
      target(i) = columns_[i] + 1.0;
    }
    Eigen::VectorXd finished = half_;
    cholesky_.FinishInPlace(finished);
    const Eigen::VectorXd wanted = gram.llt().solve(target);
    EXPECT_LE((finished - wanted).norm(), 1e-9 * wanted.norm());
  }

 private:
  const Eigen::MatrixXd& gram_;
  UpdatableCholesky cholesky_;
  std::vector<int> columns_;
  Eigen::VectorXd half_;
};

TEST(UpdatableCholeskyTest, FollowsRandomAppendsAndRemovals) {
  std::mt19937_64 random(1);
  // cond(G) of some hundreds.
  const Eigen::MatrixXd X = RandomMatrix(60, 120, random);
  const Eigen::MatrixXd gram = X * X.transpose();
  // Capacity 2: it grows several times.
  Tracked tracked(gram, 2);
  std::vector<bool> in(60, false);
  for (int step = 0; step < 600; ++step) {
    const int column = static_cast<int>(random() % 60);
    if (!in[column]) {
      EXPECT_GT(tracked.Append(column, 1e-12), 0.0);
    } else {
      const auto& columns = tracked.columns();
      tracked.Remove(static_cast<int>(
          std::find(columns.begin(), columns.end(), column) - columns.begin()));
    }
    in[column] = !in[column];
    if (!tracked.columns().empty()) tracked.ExpectRight(random);
  }
  EXPECT_GT(tracked.columns().size(), 10U);
}

TEST(UpdatableCholeskyTest, RemovesTheFirstAndTheLast) {
  std::mt19937_64 random(2);
  const Eigen::MatrixXd X = RandomMatrix(8, 30, random);
  const Eigen::MatrixXd gram = X * X.transpose();
  Tracked tracked(gram, 8);
  for (int j = 0; j < 8; ++j) tracked.Append(j, 0.0);
  tracked.Remove(0);
  tracked.ExpectRight(random);
  tracked.Remove(6);
  tracked.ExpectRight(random);
  while (tracked.cholesky().size() > 0) tracked.Remove(0);
  tracked.Append(3, 0.0);
  tracked.ExpectRight(random);
  tracked.cholesky().Clear();
  EXPECT_EQ(tracked.cholesky().size(), 0);
}

// The pivot is the squared distance from the span of the others.
TEST(UpdatableCholeskyTest, PivotIsTheSquaredDistance) {
  Eigen::MatrixXd X(3, 3);
  X << 3.0, 0.0, 0.0,  //
      5.0, 2.0, 0.0,   //
      1.0, 1.0, 4.0;
  const Eigen::MatrixXd gram = X * X.transpose();
  Tracked tracked(gram, 1);
  EXPECT_NEAR(tracked.Append(0, 0.0), 9.0, 1e-13);
  EXPECT_NEAR(tracked.Append(1, 0.0), 4.0, 1e-13);
  EXPECT_NEAR(tracked.Append(2, 0.0), 16.0, 1e-13);
  // Diagonal 3, 2, 4.
  EXPECT_NEAR(tracked.cholesky().ReciprocalConditionBound(), 0.25, 1e-14);
}

TEST(UpdatableCholeskyTest, DependentColumnsChangeNothing) {
  std::mt19937_64 random(3);
  Eigen::MatrixXd X = RandomMatrix(6, 40, random);
  X.row(3) = X.row(0) - 2.0 * X.row(1) + X.row(2);
  X.row(4) = -X.row(0);
  const Eigen::MatrixXd gram = X * X.transpose();
  Tracked tracked(gram, 6);
  for (int j = 0; j < 3; ++j) tracked.Append(j, 1e-12);
  for (const int j : {3, 4}) {
    // Dependent up to the rounding of the Gram matrix.
    EXPECT_LE(std::abs(tracked.Append(j, 1e-12)), 1e-12 * gram(j, j));
    EXPECT_EQ(tracked.cholesky().size(), 3);
  }
  tracked.ExpectRight(random);
  EXPECT_GT(tracked.Append(5, 1e-12), 1e-2 * gram(5, 5));
  tracked.ExpectRight(random);
}

TEST(UpdatableCholeskyTest, AZeroColumnIsDependent) {
  UpdatableCholesky cholesky(1);
  EXPECT_EQ(cholesky.Append(Eigen::VectorXd(0), 0.0, 0.0), 0.0);
  EXPECT_EQ(cholesky.size(), 0);
  EXPECT_EQ(cholesky.ReciprocalConditionBound(), 1.0);
}

}  // namespace
}  // namespace mle
