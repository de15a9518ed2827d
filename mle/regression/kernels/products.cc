// Products with lagged samples and with columns of G; triangular solves.
// Compiled once for each instruction set, as namespace MLE_INSTRUCTION_SET.

#include "mle/regression/kernels/instruction_sets.h"
#include "mle/regression/kernels/vectors.h"

namespace mle::MLE_INSTRUCTION_SET {
namespace {

// How many vectors of a tile's column fit beside each other: kDepth × 4 sums
// take most registers.
#if defined(__AVX512F__)
constexpr int kDepth = 6;
#else
constexpr int kDepth = 3;
#endif

// Numbers of one segment of samples: 32 KiB.
constexpr Index kSegment = 4096;

// Columns of G and of U that are gone through together, so that vectors are
// read and written less.
constexpr int kColumns = 8;
constexpr int kPanel = 4;

Index Min(Index a, Index b) { return a < b ? a : b; }

// Adds to `depth` vectors of T by `columns` of the sums.
template <typename T, int depth, int columns>
void AddTile(const ProductSeries& f, double* sums, Index stride) {
  // NOLINTNEXTLINE(bugprone-sizeof-expression): 1 where T is double.
  constexpr Index kLanes = sizeof(T) / sizeof(double);
  T tile[columns][depth];
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < depth; ++i) tile[j][i] = T{};
  }
  const double* x = f.x;
  const double* w = f.w;
  for (Index k = 0; k < f.count; ++k, x += f.x_stride, w += f.w_stride) {
    for (int i = 0; i < depth; ++i) {
      const T left = Load<T>(x + i * kLanes);
      for (int j = 0; j < columns; ++j) tile[j][i] += left * w[j];
    }
  }
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < depth; ++i) {
      double* to = sums + j * stride + i * kLanes;
      Store(Load<T>(to) + tile[j][i], to);
    }
  }
}

// The vectors of rows that are left, fewer than kDepth. Tiles of one vector
// would wait for each sum; what is summed does not depend on the tile.
template <int depth, int columns>
void AddRest(Index vectors, const ProductSeries& f, double* sums,
             Index stride) {
  if constexpr (depth > 0) {
    if (vectors == depth) {
      AddTile<Vector, depth, columns>(f, sums, stride);
    } else {
      AddRest<depth - 1, columns>(vectors, f, sums, stride);
    }
  }
}

// All rows of `columns` columns of the sums.
template <int columns>
void AddPanel(ProductSeries f, double* sums, Index stride) {
  Index row = 0;
  const auto advance = [&](Index rows) {
    row += rows;
    f.x += rows;
    sums += rows;
  };
  while (row + kDepth * kWidth <= f.rows) {
    AddTile<Vector, kDepth, columns>(f, sums, stride);
    advance(kDepth * kWidth);
  }
  const Index vectors = (f.rows - row) / kWidth;
  AddRest<kDepth - 1, columns>(vectors, f, sums, stride);
  advance(vectors * kWidth);
  while (row < f.rows) {
    AddTile<double, 1, columns>(f, sums, stride);
    advance(1);
  }
}

// gx[0, width) += G_·A x, and gq alike, for `columns` columns at `g`.
template <typename T, int columns>
void MultiplyRows(const double* const* g, const double* x, const double* q,
                  Index row, double* gx, double* gq) {
  T sum_x = Load<T>(gx + row);
  T sum_q = Load<T>(gq + row);
  for (int i = 0; i < columns; ++i) {
    const T value = Load<T>(g[i] + row);
    sum_x += value * x[i];
    sum_q += value * q[i];
  }
  Store(sum_x, gx + row);
  Store(sum_q, gq + row);
}

template <int columns>
void MultiplyPanel(const ColumnSet& set, Index first, const double* x,
                   const double* q, Index n, double* gx, double* gq) {
  const double* g[columns];
  double x_copy[columns];
  double q_copy[columns];
  for (int i = 0; i < columns; ++i) {
    g[i] = set.matrix + set.columns[first + i] * set.stride;
    x_copy[i] = x[first + i];
    q_copy[i] = q[first + i];
  }
  Index row = 0;
  for (; row + kWidth <= n; row += kWidth) {
    MultiplyRows<Vector, columns>(g, x_copy, q_copy, row, gx, gq);
  }
  for (; row < n; ++row) {
    MultiplyRows<double, columns>(g, x_copy, q_copy, row, gx, gq);
  }
}

// u_jᵀ x over the first `count` numbers of `columns` columns.
template <int columns>
void Dots(const double* u, Index stride, Index count, const double* x,
          double* dots) {
  Vector sums[columns] = {};
  Index i = 0;
  for (; i + kWidth <= count; i += kWidth) {
    const Vector value = Load<Vector>(x + i);
    for (int j = 0; j < columns; ++j) {
      sums[j] += value * Load<Vector>(u + j * stride + i);
    }
  }
  for (int j = 0; j < columns; ++j) {
    double sum = 0.0;
    for (int lane = 0; lane < kWidth; ++lane) sum += sums[j][lane];
    for (Index rest = i; rest < count; ++rest) {
      sum += x[rest] * u[j * stride + rest];
    }
    dots[j] = sum;
  }
}

// x −= u a over the first `count` numbers of `columns` columns.
template <int columns>
void SubtractColumns(const double* u, Index stride, Index count,
                     const double* a, double* x) {
  Index i = 0;
  for (; i + kWidth <= count; i += kWidth) {
    Vector value = Load<Vector>(x + i);
    for (int j = 0; j < columns; ++j) {
      value -= a[j] * Load<Vector>(u + j * stride + i);
    }
    Store(value, x + i);
  }
  for (; i < count; ++i) {
    for (int j = 0; j < columns; ++j) x[i] -= a[j] * u[j * stride + i];
  }
}

// Entries first … first + columns − 1 of U⁻ᵀ x, those before them known.
template <int columns>
void SolveTransposedPanel(const double* u, Index stride, Index first,
                          double* x) {
  double dots[columns];
  Dots<columns>(u + first * stride, stride, first, x, dots);
  for (int j = 0; j < columns; ++j) {
    const double* column = u + (first + j) * stride + first;
    double value = x[first + j] - dots[j];
    for (int i = 0; i < j; ++i) value -= column[i] * x[first + i];
    x[first + j] = value / column[j];
  }
}

// The same of U⁻¹ x, those behind them known and taken off.
template <int columns>
void SolvePanel(const double* u, Index stride, Index first, double* x) {
  for (int j = columns - 1; j >= 0; --j) {
    const double* column = u + (first + j) * stride + first;
    x[first + j] /= column[j];
    for (int i = 0; i < j; ++i) x[first + i] -= column[i] * x[first + j];
  }
  SubtractColumns<columns>(u + first * stride, stride, first, x + first, x);
}

}  // namespace

void AddProducts(const ProductSeries& series, double* sums, Index stride) {
  const Index rows_at_once = kSegment / series.x_stride;
  const Index segment = rows_at_once > 32 ? rows_at_once : 32;
  for (Index k = 0; k < series.count; k += segment) {
    ProductSeries part = series;
    part.x += k * series.x_stride;
    part.w += k * series.w_stride;
    part.count = Min(segment, series.count - k);
    for (Index j = 0; j < series.columns; j += 4, part.w += 4) {
      double* panel = sums + j * stride;
      switch (Min(series.columns - j, 4)) {
        case 4:
          AddPanel<4>(part, panel, stride);
          break;
        case 3:
          AddPanel<3>(part, panel, stride);
          break;
        case 2:
          AddPanel<2>(part, panel, stride);
          break;
        default:
          AddPanel<1>(part, panel, stride);
      }
    }
  }
}

void MultiplyColumns(const ColumnSet& columns, const double* x, const double* q,
                     Index n, double* gx, double* gq) {
  Index i = 0;
  for (; i + kColumns <= columns.count; i += kColumns) {
    MultiplyPanel<kColumns>(columns, i, x, q, n, gx, gq);
  }
  for (; i < columns.count; ++i) {
    MultiplyPanel<1>(columns, i, x, q, n, gx, gq);
  }
}

void SolveTransposed(const double* u, Index stride, Index n, double* x) {
  Index first = 0;
  for (; first + kPanel <= n; first += kPanel) {
    SolveTransposedPanel<kPanel>(u, stride, first, x);
  }
  for (; first < n; ++first) SolveTransposedPanel<1>(u, stride, first, x);
}

void Solve(const double* u, Index stride, Index n, double* x) {
  Index end = n;
  for (; end % kPanel != 0; --end) SolvePanel<1>(u, stride, end - 1, x);
  for (; end > 0; end -= kPanel) {
    SolvePanel<kPanel>(u, stride, end - kPanel, x);
  }
}

}  // namespace mle::MLE_INSTRUCTION_SET
