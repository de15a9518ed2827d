#include "mle/regression/updatable_cholesky.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Jacobi"
#include "glog/logging.h"
#include "mle/regression/kernels/kernels.h"

namespace mle {

UpdatableCholesky::UpdatableCholesky(int capacity)
    : factor_(std::max(capacity, 1), std::max(capacity, 1)) {}

double UpdatableCholesky::Append(const Eigen::Ref<const Eigen::VectorXd>& cross,
                                 double square, double tolerance) {
  CHECK_EQ(cross.size(), size_);
  if (size_ == factor_.cols()) {
    const Eigen::Index grown = 2 * factor_.cols();
    factor_.conservativeResize(grown, grown);
  }
  auto column = factor_.col(size_).head(size_);
  column = cross;
  VectorKernels().solve_transposed(factor_.data(), factor_.outerStride(), size_,
                                   column.data());
  const double pivot = square - column.squaredNorm();
  if (!(pivot > tolerance * square)) return pivot;
  factor_(size_, size_) = std::sqrt(pivot);
  ++size_;
  return pivot;
}

void UpdatableCholesky::Remove(int position) {
  CHECK(position >= 0 && position < size_);
  // The columns behind move up and are upper Hessenberg; rotation i acts on
  // rows i and i+1 of every column from i on, column by column.
  Eigen::Matrix<Eigen::JacobiRotation<double>, Eigen::Dynamic, 1> rotations(
      size_ - 1 - position);
  for (int j = position; j + 1 < size_; ++j) {
    factor_.col(j).head(j + 2) = factor_.col(j + 1).head(j + 2);
    double* column = factor_.col(j).data();
    for (int i = position; i < j; ++i) {
      const Eigen::JacobiRotation<double>& g = rotations(i - position);
      const double upper = column[i];
      const double lower = column[i + 1];
      column[i] = g.c() * upper - g.s() * lower;
      column[i + 1] = g.s() * upper + g.c() * lower;
    }
    double diagonal = 0.0;
    rotations(j - position).makeGivens(column[j], column[j + 1], &diagonal);
    // Diagonals are kept positive.
    if (diagonal < 0.0) {
      rotations(j - position).c() *= -1.0;
      rotations(j - position).s() *= -1.0;
      diagonal = -diagonal;
    }
    column[j] = diagonal;
  }
  --size_;
}

void UpdatableCholesky::SolveInPlace(Eigen::Ref<Eigen::VectorXd> x) const {
  CHECK_LE(x.size(), size_);
  const Kernels& kernels = VectorKernels();
  kernels.solve_transposed(factor_.data(), factor_.outerStride(), x.size(),
                           x.data());
  kernels.solve(factor_.data(), factor_.outerStride(), x.size(), x.data());
}

double UpdatableCholesky::InverseQuadraticForm(const Eigen::VectorXd& x) const {
  CHECK_EQ(x.size(), size_);
  Eigen::VectorXd y = x;
  VectorKernels().solve_transposed(factor_.data(), factor_.outerStride(), size_,
                                   y.data());
  return y.squaredNorm();
}

double UpdatableCholesky::ReciprocalConditionBound() const {
  if (size_ == 0) return 1.0;
  const auto diagonal = factor_.topLeftCorner(size_, size_).diagonal();
  const double ratio = diagonal.minCoeff() / diagonal.maxCoeff();
  return ratio * ratio;
}

}  // namespace mle
