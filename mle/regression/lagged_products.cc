#include "mle/regression/lagged_products.h"

#include <algorithm>
#include <cstring>

#include "glog/logging.h"

namespace mle {
namespace {

using Eigen::Index;

// A vector of the processor's widest registers, and how many such vectors of a
// tile's column fit beside each other: kDepth × 4 sums take most registers.
#if defined(__AVX512F__)
constexpr int kWidth = 8;
constexpr int kDepth = 6;
#elif defined(__AVX__)
constexpr int kWidth = 4;
constexpr int kDepth = 3;
#else
constexpr int kWidth = 2;
constexpr int kDepth = 3;
#endif
using Vector __attribute__((vector_size(kWidth * sizeof(double)))) = double;

// Numbers of one stretch of samples: 32 KiB.
constexpr Index kStretch = 4096;

struct Factors {
  const double* x;  // x_k of the stretch's first k
  Index x_stride;
  const double* w;
  Index w_stride;
  Index count;  // of k
};

template <typename T>
T Load(const double* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

// Adds to `depth` vectors of T by `columns` of the sums.
template <typename T, int depth, int columns>
void AddTile(const Factors& f, double* sums, Index sums_stride) {
  constexpr Index width = sizeof(T) / sizeof(double);
  T tile[columns][depth];
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < depth; ++i) tile[j][i] = T{};
  }
  const double* x = f.x;
  const double* w = f.w;
  for (Index k = 0; k < f.count; ++k, x += f.x_stride, w += f.w_stride) {
    for (int i = 0; i < depth; ++i) {
      const T left = Load<T>(x + i * width);
      for (int j = 0; j < columns; ++j) tile[j][i] += left * w[j];
    }
  }
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < depth; ++i) {
      double* to = sums + j * sums_stride + i * width;
      const T sum = Load<T>(to) + tile[j][i];
      std::memcpy(to, &sum, sizeof(T));
    }
  }
}

// All n rows of `columns` columns of the sums.
template <int columns>
void AddPanel(Factors f, Index n, double* sums, Index sums_stride) {
  Index row = 0;
  const auto advance = [&](Index rows) {
    row += rows;
    f.x += rows;
    sums += rows;
  };
  while (row + kDepth * kWidth <= n) {
    AddTile<Vector, kDepth, columns>(f, sums, sums_stride);
    advance(kDepth * kWidth);
  }
  while (row + kWidth <= n) {
    AddTile<Vector, 1, columns>(f, sums, sums_stride);
    advance(kWidth);
  }
  while (row < n) {
    AddTile<double, 1, columns>(f, sums, sums_stride);
    advance(1);
  }
}

}  // namespace

void AddLaggedProducts(
    const LaggedSeries::View& x,
    const Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>& w,
    Eigen::Ref<Eigen::MatrixXd> sums) {
  CHECK_EQ(x.cols(), w.cols());
  CHECK_EQ(x.rows(), sums.rows());
  CHECK_EQ(w.rows(), sums.cols());
  const Index stretch = std::max<Index>(kStretch / x.outerStride(), 32);
  for (Index k = 0; k < x.cols(); k += stretch) {
    Factors f{x.data() + k * x.outerStride(), x.outerStride(),
              w.data() + k * w.outerStride(), w.outerStride(),
              std::min(stretch, x.cols() - k)};
    for (Index j = 0; j < w.rows(); j += 4, f.w += 4) {
      double* panel = sums.data() + j * sums.outerStride();
      switch (std::min<Index>(w.rows() - j, 4)) {
        case 4:
          AddPanel<4>(f, x.rows(), panel, sums.outerStride());
          break;
        case 3:
          AddPanel<3>(f, x.rows(), panel, sums.outerStride());
          break;
        case 2:
          AddPanel<2>(f, x.rows(), panel, sums.outerStride());
          break;
        default:
          AddPanel<1>(f, x.rows(), panel, sums.outerStride());
      }
    }
  }
}

}  // namespace mle
