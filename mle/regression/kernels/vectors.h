// Vectors of the widest registers of the instruction set, in its own namespace:
// the linker mixes no copies of two sets.

#ifndef MLE_REGRESSION_KERNELS_VECTORS_H_
#define MLE_REGRESSION_KERNELS_VECTORS_H_

#include <cstddef>

namespace mle::MLE_INSTRUCTION_SET {

using Index = std::ptrdiff_t;

#if defined(__AVX512F__)
constexpr int kWidth = 8;
#elif defined(__AVX__)
constexpr int kWidth = 4;
#else
constexpr int kWidth = 2;
#endif
using Vector __attribute__((vector_size(kWidth * sizeof(double)))) = double;

template <typename T>
T Load(const double* from) {
  T value;
  __builtin_memcpy(&value, from, sizeof(T));
  return value;
}

template <typename T>
void Store(const T& value, double* to) {
  __builtin_memcpy(to, &value, sizeof(T));
}

}  // namespace mle::MLE_INSTRUCTION_SET

#endif  // MLE_REGRESSION_KERNELS_VECTORS_H_
