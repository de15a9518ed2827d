#include "mle/regression/updatable_cholesky.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "absl/types/span.h"
#include "glog/logging.h"
#include "mle/regression/kernels/kernels.h"

namespace mle {
namespace {

// Columns that rotations are applied to together: along one column each waits
// for the one before.
constexpr int kRotatedTogether = 4;

struct Rotation {
  double c = 1.0;
  double s = 0.0;
};

// Rotation i turns entries i and i+1 of N columns, which are read from `from`
// on and written one column before, or where they stand.
template <int N>
void Rotate(absl::Span<const Rotation> rotations, Eigen::Index stride,
            const double* from, double* to) {
  double upper[N];
  for (int n = 0; n < N; ++n) upper[n] = from[n * stride];
  for (const auto& [c, s] : rotations) {
    ++from;
    for (int n = 0; n < N; ++n) {
      const double lower = from[n * stride];
      to[n * stride] = c * upper[n] + s * lower;
      upper[n] = c * lower - s * upper[n];
    }
    ++to;
  }
  for (int n = 0; n < N; ++n) to[n * stride] = upper[n];
}

}  // namespace

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

void UpdatableCholesky::Remove(int position, Eigen::Ref<Eigen::VectorXd> z) {
  CHECK(position >= 0 && position < size_);
  CHECK_EQ(z.size(), size_);
  // The columns behind move up and are upper Hessenberg; rotation i acts on
  // rows i and i+1 of every column from i on, and of z.
  const int last = size_ - 1;
  std::vector<Rotation> rotations(last - position);
  const Eigen::Index stride = factor_.outerStride();
  const auto up_to = [&](int first, int end) {
    return absl::Span<const Rotation>(rotations.data() + first - position,
                                      static_cast<std::size_t>(end - first));
  };
  for (int first = position; first < last; first += kRotatedTogether) {
    const int end = std::min(first + kRotatedTogether, last);
    for (int j = first; j < end; ++j) {
      factor_.col(j).head(position) = factor_.col(j + 1).head(position);
    }
    double* const columns = factor_.data() + position;
    if (end - first == kRotatedTogether) {
      Rotate<kRotatedTogether>(up_to(position, first), stride,
                               columns + stride * (first + 1),
                               columns + stride * first);
    } else {
      for (int j = first; j < end; ++j) {
        Rotate<1>(up_to(position, first), 0, columns + stride * (j + 1),
                  columns + stride * j);
      }
    }
    for (int j = first; j < end; ++j) {
      // Entries below the rotations so far still stand in the next column.
      double* const column = factor_.col(j).data();
      for (int i = first + 1; i <= j + 1; ++i) column[i] = factor_(i, j + 1);
      Rotate<1>(up_to(first, j), 0, column + first, column + first);
      const double size = std::hypot(column[j], column[j + 1]);
      if (size > 0.0) {
        rotations[j - position] = {column[j] / size, column[j + 1] / size};
      }
      column[j] = size;
    }
  }
  Rotate<1>(rotations, 0, z.data() + position, z.data() + position);
  --size_;
}

void UpdatableCholesky::HalfSolveInPlace(Eigen::Ref<Eigen::VectorXd> z) const {
  CHECK_LE(z.size(), size_);
  VectorKernels().solve_transposed(factor_.data(), factor_.outerStride(),
                                   z.size(), z.data());
}

double UpdatableCholesky::LastOfHalf(const Eigen::Ref<const Eigen::VectorXd>& z,
                                     double target) const {
  const int last = size_ - 1;
  return (target - factor_.col(last).head(last).dot(z)) / factor_(last, last);
}

void UpdatableCholesky::FinishInPlace(Eigen::Ref<Eigen::VectorXd> x) const {
  CHECK_LE(x.size(), size_);
  VectorKernels().solve(factor_.data(), factor_.outerStride(), x.size(),
                        x.data());
}

void UpdatableCholesky::SolveInPlace(Eigen::Ref<Eigen::VectorXd> x) const {
  HalfSolveInPlace(x);
  FinishInPlace(x);
}

double UpdatableCholesky::InverseQuadraticForm(const Eigen::VectorXd& x) const {
  CHECK_EQ(x.size(), size_);
  Eigen::VectorXd y = x;
  HalfSolveInPlace(y);
  return y.squaredNorm();
}

double UpdatableCholesky::ReciprocalConditionBound() const {
  if (size_ == 0) return 1.0;
  const auto diagonal = factor_.topLeftCorner(size_, size_).diagonal();
  const double ratio = diagonal.minCoeff() / diagonal.maxCoeff();
  return ratio * ratio;
}

}  // namespace mle
