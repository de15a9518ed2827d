#include "mle/model/largest_gain.h"

#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXcd;

// In place, of a power of two of values: Σ_l v_l e^{−2πjkl/M} (Cooley and
// Tukey, Math. Comp. 19, 1965).
void FourierTransform(VectorXcd& values) {
  const Index size = values.size();
  for (Index i = 1, reversed = 0; i < size; ++i) {
    Index bit = size >> 1;
    for (; (reversed & bit) != 0; bit >>= 1) reversed ^= bit;
    reversed ^= bit;
    if (i < reversed) std::swap(values(i), values(reversed));
  }
  VectorXcd turns(size / 2);
  for (Index k = 0; k < turns.size(); ++k) {
    turns(k) =
        std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k) /
                            static_cast<double>(size));
  }
  for (Index half = 1; half < size; half *= 2) {
    const Index stride = size / (2 * half);
    for (Index first = 0; first < size; first += 2 * half) {
      for (Index k = 0; k < half; ++k) {
        const std::complex<double> even = values(first + k);
        const std::complex<double> odd =
            values(first + half + k) * turns(k * stride);
        values(first + k) = even + odd;
        values(first + half + k) = even - odd;
      }
    }
  }
}

}  // namespace

double LargestGainBound(const Eigen::VectorXd& impulse) {
  if (impulse.size() == 0) return 0.0;
  const auto points = static_cast<Index>(
      std::bit_ceil(static_cast<std::size_t>(8 * impulse.size())));
  VectorXcd values = VectorXcd::Zero(points);
  values.head(impulse.size()) = impulse.cast<std::complex<double>>();
  FourierTransform(values);
  const double degree = static_cast<double>(impulse.size() - 1);
  const double nearest =
      std::cos(std::numbers::pi * degree / static_cast<double>(points));
  return values.cwiseAbs().maxCoeff() / std::sqrt(nearest);
}

}  // namespace mle
