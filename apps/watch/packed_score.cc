#include "apps/watch/packed_score.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "apps/watch/raw_bytes.h"
#include "glog/logging.h"

namespace mle::watch {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of the diagonal: what is left of it below is not told from rounding.
constexpr double kNothing = 1e-9;
// Bits besides the sign: of pivots and of z, and of the others. The exponent is
// the first for which they suffice.
constexpr int kFine = 15;
constexpr int kCoarse = 11;
// Stands for a row of zeros.
constexpr int kZeros = -128;

double LargestOf(int bits) { return std::ldexp(1.0, bits) - 1.0; }

// The least e for which `largest` ≥ 0 is below 2^e, as it is rounded.
int ExponentFor(double largest, int bits) {
  if (!(largest > 0.0)) return kZeros;
  int exponent = 0;
  const double fraction = std::frexp(largest, &exponent);
  // What would be rounded up to 2^e.
  if (std::ldexp(fraction, bits) > LargestOf(bits) + 0.5) ++exponent;
  return std::clamp(exponent, kZeros + 1, 127);
}

double StepOf(int exponent, int bits) {
  return exponent == kZeros ? 0.0 : std::ldexp(1.0, exponent - bits);
}

int Rounded(double value, int exponent, int bits) {
  if (exponent == kZeros) return 0;
  const double largest = LargestOf(bits);
  return static_cast<int>(std::lround(
      std::clamp(value / StepOf(exponent, bits), -largest, largest)));
}

void PutFine(double value, int exponent, std::string& bytes) {
  PutRaw(static_cast<std::int16_t>(Rounded(value, exponent, kFine)), bytes);
}

double TakeFine(int exponent, std::string_view& bytes) {
  return TakeRaw<std::int16_t>(bytes) * StepOf(exponent, kFine);
}

// Numbers of 12 bits, one after the other, the lowest bits first.
void PutCoarse(const std::vector<int>& numbers, std::string& bytes) {
  unsigned pending = 0;
  int bits = 0;
  for (const int number : numbers) {
    pending |= (static_cast<unsigned>(number) & 0xfffU) << bits;
    for (bits += kCoarse + 1; bits >= 8; bits -= 8, pending >>= 8) {
      bytes += static_cast<char>(pending & 0xffU);
    }
  }
  if (bits > 0) bytes += static_cast<char>(pending);
}

std::size_t SizeOfCoarse(std::size_t count) {
  return (count * (kCoarse + 1) + 7) / 8;
}

// That of its place among them.
int CoarseAt(std::string_view bytes, std::size_t place) {
  const std::size_t nibble = 3 * place;
  const auto low = static_cast<unsigned char>(bytes[nibble / 2]);
  const auto high = static_cast<unsigned char>(bytes[nibble / 2 + 1]);
  const int value = ((low | high << 8) >> (nibble % 2 * 4)) & 0xfff;
  return value < 1 << kCoarse ? value : value - (2 << kCoarse);
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
  return n + 2 * n + SizeOfCoarse(n * (n - 1) / 2) + 1 + 2 * n;
}

void Pack(const ScorePart& part, std::string& bytes) {
  const Index n = part.score.size();
  const MatrixXd factor = FactorOf(part.information);
  std::string pivots;
  std::vector<int> others;
  VectorXd whitened = VectorXd::Zero(n);
  for (Index a = 0; a < n; ++a) {
    const auto before = factor.row(a).head(a);
    const double largest = a == 0 ? 0.0 : before.cwiseAbs().maxCoeff();
    const int exponent = std::max(ExponentFor(factor(a, a), kFine),
                                  ExponentFor(largest, kCoarse));
    bytes += static_cast<char>(exponent);
    PutFine(factor(a, a), exponent, pivots);
    for (const double value : before) {
      others.push_back(Rounded(value, exponent, kCoarse));
    }
    if (factor(a, a) == 0.0) continue;
    whitened(a) = (part.score(a) - before.dot(whitened.head(a))) / factor(a, a);
  }
  bytes += pivots;
  PutCoarse(others, bytes);
  const int exponent =
      ExponentFor(n > 0 ? whitened.cwiseAbs().maxCoeff() : 0.0, kFine);
  bytes += static_cast<char>(exponent);
  for (const double value : whitened) PutFine(value, exponent, bytes);
}

ScorePart Unpack(std::size_t n, std::string_view bytes) {
  CHECK_EQ(bytes.size(), PackedSize(n));
  const auto size = static_cast<Index>(n);
  std::vector<int> exponents;
  for (Index a = 0; a < size; ++a) {
    exponents.push_back(TakeRaw<signed char>(bytes));
  }
  MatrixXd factor = MatrixXd::Zero(size, size);
  for (Index a = 0; a < size; ++a) {
    factor(a, a) = TakeFine(exponents[a], bytes);
  }
  std::size_t place = 0;
  for (Index a = 0; a < size; ++a) {
    const double step = StepOf(exponents[a], kCoarse);
    for (Index c = 0; c < a; ++c) {
      factor(a, c) = CoarseAt(bytes, place++) * step;
    }
  }
  bytes.remove_prefix(SizeOfCoarse(place));
  const int exponent = TakeRaw<signed char>(bytes);
  VectorXd whitened(size);
  for (double& value : whitened) value = TakeFine(exponent, bytes);
  return {factor * whitened, factor * factor.transpose()};
}

}  // namespace mle::watch
