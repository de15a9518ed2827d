// Arguments of the kernels: raw arrays, matrices stored by columns, with
// `stride` numbers from one column to the next.

#ifndef MLE_REGRESSION_KERNELS_ARGUMENTS_H_
#define MLE_REGRESSION_KERNELS_ARGUMENTS_H_

#include <cstddef>

namespace mle {

// Columns `columns` (count) of a matrix.
struct ColumnSet {
  const double* matrix = nullptr;
  std::ptrdiff_t stride = 0;
  const int* columns = nullptr;
  std::ptrdiff_t count = 0;
};

// Σ_k x_k w_kᵀ: x_k has `rows` numbers, w_k `columns`.
struct ProductSeries {
  const double* x = nullptr;
  std::ptrdiff_t x_stride = 0;  // may be less than `rows`: lags overlap
  std::ptrdiff_t rows = 0;
  const double* w = nullptr;
  std::ptrdiff_t w_stride = 0;
  std::ptrdiff_t columns = 0;
  std::ptrdiff_t count = 0;  // of k
};

// A filter of innovations, sample by sample (nonlinear/innovations_filter.h):
// gain of the level w, 1/√F, and of each sample with an AR component four
// numbers: own, cross, and the gains of a and b.
struct FilterSteps {
  const double* gains = nullptr;
  const double* inverse_roots = nullptr;
  const double* ar = nullptr;  // nullptr: none
  double spread = 0.0;
};

// Elements of first order side by side, as the columns of a linearised model:
// with u of the sample before and of this one, for each of `width` elements
//
//   y ← a y + b₁ u₁ + b₀ u₀,   d ← a d + e y + c₁ u₁ + c₀ u₀,
//   s = f y + h u₁,
//
// and what all make together, Σ K y. Rows of nine numbers for each element: a,
// b₁, b₀, e, c₁, c₀, f, h, K.
struct FirstOrderElements {
  static constexpr std::ptrdiff_t kNumbers = 9;
  const double* numbers = nullptr;  // kNumbers × width, zero behind `count`
  std::ptrdiff_t width = 0;         // of whole vectors of 8
  std::ptrdiff_t count = 0;         // of elements, ≤ width
};

}  // namespace mle

#endif  // MLE_REGRESSION_KERNELS_ARGUMENTS_H_
