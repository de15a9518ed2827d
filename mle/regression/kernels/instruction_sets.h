// Declarations that the files compiled once for each instruction set share.
//
// They include no header with inline functions but of their own namespace
// (vectors.h): the linker keeps one copy of each, and it might be one that not
// every processor can run.

#ifndef MLE_REGRESSION_KERNELS_INSTRUCTION_SETS_H_
#define MLE_REGRESSION_KERNELS_INSTRUCTION_SETS_H_

#include <cstddef>

#include "mle/regression/kernels/arguments.h"

namespace mle {

#define MLE_DECLARE_KERNELS(set)                                             \
  namespace set {                                                            \
  void AddProducts(const ProductSeries& series, double* sums,                \
                   std::ptrdiff_t stride);                                   \
  void MultiplyColumns(const ColumnSet& columns, const double* x,            \
                       const double* q, std::ptrdiff_t n, double* gx,        \
                       double* gq);                                          \
  void SubtractColumnsTwice(const ColumnSet& columns, const double* x,       \
                            std::ptrdiff_t n, double* high, double* low);    \
  void SolveTransposed(const double* u, std::ptrdiff_t stride,               \
                       std::ptrdiff_t n, double* x);                         \
  void Solve(const double* u, std::ptrdiff_t stride, std::ptrdiff_t n,       \
             double* x);                                                     \
  void FilterRows(const FilterSteps& steps, std::ptrdiff_t count,            \
                  double* rows, std::ptrdiff_t stride, std::ptrdiff_t width, \
                  double* state);                                            \
  void RunFirstOrder(const FirstOrderElements& elements,                     \
                     std::ptrdiff_t samples, const double* inputs,           \
                     double* state, double* sums, double* rows,              \
                     std::ptrdiff_t stride, std::ptrdiff_t between);         \
  }

MLE_DECLARE_KERNELS(baseline)
MLE_DECLARE_KERNELS(avx2)
MLE_DECLARE_KERNELS(avx512)

#undef MLE_DECLARE_KERNELS

}  // namespace mle

#endif  // MLE_REGRESSION_KERNELS_INSTRUCTION_SETS_H_
