// The filter of innovations over rows of many columns.
// Compiled once for each instruction set, as namespace MLE_INSTRUCTION_SET.

#include "mle/regression/kernels/instruction_sets.h"
#include "mle/regression/kernels/vectors.h"

namespace mle::MLE_INSTRUCTION_SET {
namespace {

// Vectors of columns that are filtered at once: each sample waits for the one
// before, and recurrences that do not need each other fill the time.
constexpr int kBeside = 4;

// `depth` vectors of T from the columns that `from`, `rows` and `state` begin
// at.
template <typename T, int depth, bool coloured>
void FilterTile(const FilterSteps& steps, Index count, const double* from,
                Index from_stride, double* rows, Index stride, double* state,
                Index width) {
  // NOLINTNEXTLINE(bugprone-sizeof-expression): 1 where T is double.
  constexpr Index kLanes = sizeof(T) / sizeof(double);
  T level[depth];
  T a[depth];
  T b[depth];
  for (int i = 0; i < depth; ++i) {
    level[i] = Load<T>(state + i * kLanes);
    if constexpr (coloured) {
      a[i] = Load<T>(state + width + i * kLanes);
      b[i] = Load<T>(state + 2 * width + i * kLanes);
    }
  }
  const double* colour = steps.colour;
  for (Index k = 0; k < count; ++k, from += from_stride, rows += stride) {
    const double gain = steps.gains[k];
    const double root = steps.inverse_roots[k];
    for (int i = 0; i < depth; ++i) {
      const T value = Load<T>(from + i * kLanes);
      T innovation;
      if constexpr (coloured) {
        innovation = value - (level[i] + a[i]);
        const T next =
            colour[0] * a[i] + colour[1] * b[i] + colour[2] * innovation;
        b[i] = steps.spread * colour[1] * a[i] + colour[0] * b[i] +
               colour[3] * innovation;
        a[i] = next;
      } else {
        innovation = value - level[i];
      }
      level[i] += gain * innovation;
      Store(innovation * root, rows + i * kLanes);
    }
    if constexpr (coloured) colour += 4;
  }
  for (int i = 0; i < depth; ++i) {
    Store(level[i], state + i * kLanes);
    if constexpr (coloured) {
      Store(a[i], state + width + i * kLanes);
      Store(b[i], state + 2 * width + i * kLanes);
    }
  }
}

template <bool coloured>
void FilterAll(const FilterSteps& steps, Index count, const double* from,
               Index from_stride, double* rows, Index stride, Index width,
               double* state) {
  Index c = 0;
  for (; c + kBeside * kWidth <= width; c += kBeside * kWidth) {
    FilterTile<Vector, kBeside, coloured>(steps, count, from + c, from_stride,
                                          rows + c, stride, state + c, width);
  }
  for (; c + kWidth <= width; c += kWidth) {
    FilterTile<Vector, 1, coloured>(steps, count, from + c, from_stride,
                                    rows + c, stride, state + c, width);
  }
  for (; c < width; ++c) {
    FilterTile<double, 1, coloured>(steps, count, from + c, from_stride,
                                    rows + c, stride, state + c, width);
  }
}

}  // namespace

void FilterRows(const FilterSteps& steps, Index count, const double* from,
                Index from_stride, double* rows, Index stride, Index width,
                double* state) {
  if (steps.colour != nullptr) {
    FilterAll<true>(steps, count, from, from_stride, rows, stride, width,
                    state);
  } else {
    FilterAll<false>(steps, count, from, from_stride, rows, stride, width,
                     state);
  }
}

}  // namespace mle::MLE_INSTRUCTION_SET
