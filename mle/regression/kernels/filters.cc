// The filter of innovations over rows of many columns, and elements of first
// order side by side.
// Compiled once for each instruction set, as namespace MLE_INSTRUCTION_SET.

#include "mle/regression/kernels/instruction_sets.h"
#include "mle/regression/kernels/vectors.h"

namespace mle::MLE_INSTRUCTION_SET {
namespace {

// Vectors of columns that are filtered at once: each sample waits for the one
// before, and recurrences that do not need each other fill the time.
constexpr int kBeside = 4;

// `depth` vectors of T from the columns that `rows` and `state` begin at.
template <typename T, int depth, bool has_ar>
void FilterTile(const FilterSteps& steps, Index count, double* rows,
                Index stride, double* state, Index width) {
  // NOLINTNEXTLINE(bugprone-sizeof-expression): 1 where T is double.
  constexpr Index kLanes = sizeof(T) / sizeof(double);
  T level[depth];
  T a[depth];
  T b[depth];
  for (int i = 0; i < depth; ++i) {
    level[i] = Load<T>(state + i * kLanes);
    if constexpr (has_ar) {
      a[i] = Load<T>(state + width + i * kLanes);
      b[i] = Load<T>(state + 2 * width + i * kLanes);
    }
  }
  const double* ar = steps.ar;
  for (Index k = 0; k < count; ++k, rows += stride) {
    const double gain = steps.gains[k];
    const double root = steps.inverse_roots[k];
    for (int i = 0; i < depth; ++i) {
      const T value = Load<T>(rows + i * kLanes);
      T innovation;
      if constexpr (has_ar) {
        innovation = value - (level[i] + a[i]);
        const T next = ar[0] * a[i] + ar[1] * b[i] + ar[2] * innovation;
        b[i] = steps.spread * ar[1] * a[i] + ar[0] * b[i] + ar[3] * innovation;
        a[i] = next;
      } else {
        innovation = value - level[i];
      }
      level[i] += gain * innovation;
      Store(innovation * root, rows + i * kLanes);
    }
    if constexpr (has_ar) ar += 4;
  }
  for (int i = 0; i < depth; ++i) {
    Store(level[i], state + i * kLanes);
    if constexpr (has_ar) {
      Store(a[i], state + width + i * kLanes);
      Store(b[i], state + 2 * width + i * kLanes);
    }
  }
}

template <bool has_ar>
void FilterAll(const FilterSteps& steps, Index count, double* rows,
               Index stride, Index width, double* state) {
  Index c = 0;
  for (; c + kBeside * kWidth <= width; c += kBeside * kWidth) {
    FilterTile<Vector, kBeside, has_ar>(steps, count, rows + c, stride,
                                        state + c, width);
  }
  for (; c + kWidth <= width; c += kWidth) {
    FilterTile<Vector, 1, has_ar>(steps, count, rows + c, stride, state + c,
                                  width);
  }
  for (; c < width; ++c) {
    FilterTile<double, 1, has_ar>(steps, count, rows + c, stride, state + c,
                                  width);
  }
}

// `depth` vectors of elements, from element `first` on.
template <int depth, bool derivatives>
void RunTile(const FirstOrderElements& elements, Index first, Index samples,
             const double* inputs, double* state, double* sums, double* rows,
             Index stride, Index between) {
  constexpr int kNumbers = FirstOrderElements::kNumbers;
  const Index width = elements.width;
  Vector by[kNumbers][depth];
  Vector y[depth];
  Vector d[depth];
  Vector before[depth];  // u₁
  for (int i = 0; i < depth; ++i) {
    const Index at = first + i * kWidth;
    for (int n = 0; n < kNumbers; ++n) {
      by[n][i] = Load<Vector>(elements.numbers + n * width + at);
    }
    y[i] = Load<Vector>(state + at);
    d[i] = Load<Vector>(state + width + at);
    before[i] = Load<Vector>(inputs + at);
  }
  // Elements of the last vector, of which there may be fewer.
  const Index last = first + (depth - 1) * kWidth;
  const Index left = elements.count - last;
  for (Index k = 0; k < samples; ++k) {
    inputs += width;
    Vector sum = {};
    for (int i = 0; i < depth; ++i) {
      sum += by[8][i] * y[i];
      const Vector now = Load<Vector>(inputs + first + i * kWidth);
      if constexpr (derivatives) {
        double* to = rows + first + i * kWidth;
        const Vector s = by[6][i] * y[i] + by[7][i] * before[i];
        if (i + 1 < depth || left >= kWidth) {
          Store(y[i], to);
          Store(d[i], to + between);
          Store(s, to + 2 * between);
        } else {
          for (Index lane = 0; lane < left; ++lane) {
            to[lane] = y[i][lane];
            to[between + lane] = d[i][lane];
            to[2 * between + lane] = s[lane];
          }
        }
        d[i] = by[0][i] * d[i] + by[3][i] * y[i] +
               (by[4][i] * before[i] + by[5][i] * now);
      }
      y[i] = by[0][i] * y[i] + (by[1][i] * before[i] + by[2][i] * now);
      before[i] = now;
    }
    double total = 0.0;
    for (int lane = 0; lane < kWidth; ++lane) total += sum[lane];
    sums[k] += total;
    rows += stride;
  }
  for (int i = 0; i < depth; ++i) {
    const Index at = first + i * kWidth;
    Store(y[i], state + at);
    Store(d[i], state + width + at);
  }
}

template <bool derivatives>
void RunAll(const FirstOrderElements& elements, Index samples,
            const double* inputs, double* state, double* sums, double* rows,
            Index stride, Index between) {
  Index first = 0;
  for (; first + kWidth < elements.count; first += 2 * kWidth) {
    RunTile<2, derivatives>(elements, first, samples, inputs, state, sums, rows,
                            stride, between);
  }
  if (first < elements.count) {
    RunTile<1, derivatives>(elements, first, samples, inputs, state, sums, rows,
                            stride, between);
  }
}

}  // namespace

void RunFirstOrder(const FirstOrderElements& elements, Index samples,
                   const double* inputs, double* state, double* sums,
                   double* rows, Index stride, Index between) {
  if (rows != nullptr) {
    RunAll<true>(elements, samples, inputs, state, sums, rows, stride, between);
  } else {
    RunAll<false>(elements, samples, inputs, state, sums, rows, 0, 0);
  }
}

void FilterRows(const FilterSteps& steps, Index count, double* rows,
                Index stride, Index width, double* state) {
  if (steps.ar != nullptr) {
    FilterAll<true>(steps, count, rows, stride, width, state);
  } else {
    FilterAll<false>(steps, count, rows, stride, width, state);
  }
}

}  // namespace mle::MLE_INSTRUCTION_SET
