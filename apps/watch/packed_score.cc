#include "apps/watch/packed_score.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "apps/watch/raw_bytes.h"
#include "glog/logging.h"

namespace mle::watch {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of the diagonal: what is left of it below is not told from rounding.
constexpr double kNothing = 1e-9;
// Largest number kept; its exponent is the first for which it suffices.
constexpr int kBits = 15;
constexpr double kLargest = 32767.0;
// Stands for a row of zeros.
constexpr int kZeros = -128;

// The least e for which every |value| is below 2^e.
int ExponentFor(double largest) {
  if (!(largest > 0.0)) return kZeros;
  int exponent = 0;
  const double fraction = std::frexp(largest, &exponent);
  // What would be rounded up to 2^e.
  if (fraction * (1 << kBits) > kLargest + 0.5) ++exponent;
  return std::clamp(exponent, kZeros + 1, 127);
}

double StepOf(int exponent) {
  return exponent == kZeros ? 0.0 : std::ldexp(1.0, exponent - kBits);
}

std::int16_t Rounded(double value, double step) {
  if (step == 0.0) return 0;
  return static_cast<std::int16_t>(
      std::lround(std::clamp(value / step, -kLargest, kLargest)));
}

// L of V, a column of zeros where V says nothing.
MatrixXd FactorOf(const MatrixXd& information) {
  const Index n = information.rows();
  MatrixXd factor = MatrixXd::Zero(n, n);
  for (Index c = 0; c < n; ++c) {
    const double left = information(c, c) - factor.row(c).head(c).squaredNorm();
    if (!(left > kNothing * information(c, c))) continue;
    factor(c, c) = std::sqrt(left);
    for (Index r = c + 1; r < n; ++r) {
      factor(r, c) = (information(r, c) -
                      factor.row(r).head(c).dot(factor.row(c).head(c))) /
                     factor(c, c);
    }
  }
  return factor;
}

}  // namespace

std::size_t PackedSize(std::size_t n) {
  return n + 2 * (n * (n + 1) / 2) + 1 + 2 * n;
}

void Pack(const ScorePart& part, std::string& bytes) {
  const Index n = part.score.size();
  MatrixXd factor = FactorOf(part.information);
  std::string numbers;
  for (Index r = 0; r < n; ++r) {
    const int exponent =
        ExponentFor(factor.row(r).head(r + 1).cwiseAbs().maxCoeff());
    const double step = StepOf(exponent);
    bytes += static_cast<char>(exponent);
    for (Index c = 0; c <= r; ++c) {
      const std::int16_t kept = Rounded(factor(r, c), step);
      factor(r, c) = kept * step;
      PutRaw<std::int16_t>(kept, numbers);
    }
  }
  bytes += numbers;
  VectorXd whitened = VectorXd::Zero(n);
  for (Index a = 0; a < n; ++a) {
    if (factor(a, a) == 0.0) continue;
    whitened(a) =
        (part.score(a) - factor.row(a).head(a).dot(whitened.head(a))) /
        factor(a, a);
  }
  const int exponent =
      ExponentFor(n > 0 ? whitened.cwiseAbs().maxCoeff() : 0.0);
  bytes += static_cast<char>(exponent);
  for (const double value : whitened) {
    PutRaw<std::int16_t>(Rounded(value, StepOf(exponent)), bytes);
  }
}

ScorePart Unpack(std::size_t n, std::string_view bytes) {
  CHECK_EQ(bytes.size(), PackedSize(n));
  const auto size = static_cast<Index>(n);
  const std::string_view exponents = bytes.substr(0, n);
  bytes.remove_prefix(n);
  MatrixXd factor = MatrixXd::Zero(size, size);
  for (Index r = 0; r < size; ++r) {
    const double step = StepOf(
        static_cast<signed char>(exponents[static_cast<std::size_t>(r)]));
    for (Index c = 0; c <= r; ++c) {
      factor(r, c) = TakeRaw<std::int16_t>(bytes) * step;
    }
  }
  const double step = StepOf(static_cast<signed char>(bytes.front()));
  bytes.remove_prefix(1);
  VectorXd whitened(size);
  for (double& value : whitened) value = TakeRaw<std::int16_t>(bytes) * step;
  return {factor * whitened, factor * factor.transpose()};
}

}  // namespace mle::watch
