// The inner loops of the lasso engine and of likelihoods, compiled once for
// each set of vector instructions and chosen when the program runs. So one
// program is fast on every processor, and none of Eigen's types depends on the
// processor.
//
// Loops run over raw arrays, in an order that depends on sizes and instruction
// set alone, not on addresses: the same input gives the same bytes with any
// number of threads. Between instruction sets results differ by rounding.

#ifndef MLE_REGRESSION_KERNELS_KERNELS_H_
#define MLE_REGRESSION_KERNELS_KERNELS_H_

#include <cstddef>
#include <vector>

#include "mle/regression/kernels/arguments.h"

namespace mle {

struct Kernels {
  const char* instruction_set = "";

  // sums (rows × columns) += Σ_k x_k w_kᵀ.
  void (*add_products)(const ProductSeries& series, double* sums,
                       std::ptrdiff_t stride);

  // gx += G_·A x and gq += G_·A q, each of n numbers, in one pass over G.
  void (*multiply_columns)(const ColumnSet& columns, const double* x,
                           const double* q, std::ptrdiff_t n, double* gx,
                           double* gq);

  // high + low −= G_·A x, of n numbers, in twice the working precision (Ogita,
  // Rump and Oishi, SIAM J. Sci. Comput. 26, 2005, algorithm 5.3): what
  // rounding takes from `high` is kept in `low`.
  void (*subtract_columns_twice)(const ColumnSet& columns, const double* x,
                                 std::ptrdiff_t n, double* high, double* low);

  // x ← U⁻ᵀ x and x ← U⁻¹ x for an upper triangular U (n × n).
  void (*solve_transposed)(const double* u, std::ptrdiff_t stride,
                           std::ptrdiff_t n, double* x);
  void (*solve)(const double* u, std::ptrdiff_t stride, std::ptrdiff_t n,
                double* x);

  // Each of `count` rows of `width` numbers becomes its innovations over √F:
  //
  //   ν = x − w − a,   w += g_w ν,   a ← m a + c b + g_a ν,
  //   b ← d c a + m b + g_b ν.
  //
  // `state` (3 × width: w, a, b) is where the rows before left it.
  void (*filter_rows)(const FilterSteps& steps, std::ptrdiff_t count,
                      double* rows, std::ptrdiff_t stride, std::ptrdiff_t width,
                      double* state);

  // `samples` of elements of first order: sums (samples) += Σ K y, and in each
  // of as many rows y, d and s of all elements, `between` numbers from one to
  // the other; `rows` is nullptr where sums alone are asked for. `inputs` has
  // samples + 1 rows of `width`, `state` (2 × width: y, d) is where the samples
  // before left it.
  void (*run_first_order)(const FirstOrderElements& elements,
                          std::ptrdiff_t samples, const double* inputs,
                          double* state, double* sums, double* rows,
                          std::ptrdiff_t stride, std::ptrdiff_t between);
};

// Those this processor can run, the slowest ("baseline": what the compiler
// takes for granted) first.
std::vector<Kernels> AvailableKernels();

// The fastest of them, or the one that the environment variable
// MLE_INSTRUCTION_SET names: "baseline" gives the same bytes on all processors
// of a kind. Another name is answered in the log, and the fastest taken.
const Kernels& VectorKernels();

}  // namespace mle

#endif  // MLE_REGRESSION_KERNELS_KERNELS_H_
