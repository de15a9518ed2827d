// Sums in twice the working precision. Compiled once for each instruction set,
// as namespace MLE_INSTRUCTION_SET, and with -ffp-contract=off: a product fused
// with a sum would have no rounding error left to keep.

#include "mle/regression/kernels/instruction_sets.h"

namespace mle::MLE_INSTRUCTION_SET {
namespace {

using Index = std::ptrdiff_t;

// high + low −= x y.
inline void SubtractProduct(double x, double y, double& high, double& low) {
  const double product = -x * y;
  const double sum = high + product;
  const double part = sum - high;
  low += __builtin_fma(-x, y, -product) +
         ((high - (sum - part)) + (product - part));
  high = sum;
}

}  // namespace

void SubtractColumnsTwice(const ColumnSet& columns, const double* x, Index n,
                          double* __restrict high, double* __restrict low) {
  for (Index i = 0; i < columns.count; ++i) {
    const double* g = columns.matrix + columns.columns[i] * columns.stride;
    const double factor = x[i];
    for (Index j = 0; j < n; ++j) {
      SubtractProduct(factor, g[j], high[j], low[j]);
    }
  }
}

}  // namespace mle::MLE_INSTRUCTION_SET
