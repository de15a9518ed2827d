#include "apps/watch/scores_of_version_4.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "apps/watch/codec.h"
#include "apps/watch/raw_bytes.h"

namespace mle::watch {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr char kPacked4 = 0;
constexpr char kUnpacked4 = 1;
constexpr int kBits4 = 15;
constexpr int kZeros4 = -128;

bool IsOfVersion3(std::string_view bytes) {
  return !bytes.empty() && bytes.front() != kPacked4 &&
         bytes.front() != kUnpacked4;
}

std::size_t SizeOfVersion4(bool packed, std::size_t n) {
  const std::size_t triangle = n * (n + 1) / 2;
  return packed ? 3 * n + 2 * triangle + 1 : sizeof(float) * (n + triangle);
}

double StepOfVersion4(char exponent) {
  const int value = static_cast<signed char>(exponent);
  return value == kZeros4 ? 0.0 : std::ldexp(1.0, value - kBits4);
}

ScorePart TakePacked(std::size_t n, std::string_view& bytes) {
  const auto size = static_cast<Index>(n);
  const std::string_view exponents = bytes.substr(0, n);
  bytes.remove_prefix(n);
  MatrixXd factor = MatrixXd::Zero(size, size);
  for (Index r = 0; r < size; ++r) {
    const double step = StepOfVersion4(exponents[static_cast<std::size_t>(r)]);
    for (Index c = 0; c <= r; ++c) {
      factor(r, c) = TakeRaw<std::int16_t>(bytes) * step;
    }
  }
  const double step = StepOfVersion4(TakeRaw<char>(bytes));
  VectorXd whitened(size);
  for (double& value : whitened) value = TakeRaw<std::int16_t>(bytes) * step;
  return {factor * whitened, factor * factor.transpose()};
}

ScorePart TakeUnpacked(std::size_t n, std::string_view& bytes) {
  const auto size = static_cast<Index>(n);
  ScorePart part = {VectorXd(size), MatrixXd(size, size)};
  for (double& value : part.score) value = TakeRaw<float>(bytes);
  for (Index r = 0; r < size; ++r) {
    for (Index c = 0; c <= r; ++c) {
      part.information(r, c) = part.information(c, r) = TakeRaw<float>(bytes);
    }
  }
  return part;
}

}  // namespace

std::string AsVersion4Wrote(std::string_view bytes) {
  if (!IsOfVersion3(bytes)) return std::string(bytes);
  return std::string{kUnpacked4, bytes.front(), 0}.append(bytes.substr(1));
}

absl::StatusOr<StoredBatch> DecodeBatchOfVersion4(std::string_view bytes) {
  const auto damaged =
      absl::DataLossError("the scores of a day cannot be read");
  const bool older = IsOfVersion3(bytes);
  if (bytes.size() < (older ? 1U : 3U)) return damaged;
  const bool packed = !older && TakeRaw<char>(bytes) == kPacked4;
  const std::size_t n = TakeRaw<unsigned char>(bytes);
  const bool has_largest = !older && TakeRaw<char>(bytes) != 0;
  if (n == 0 || n % 3 != 0 ||
      bytes.size() != (has_largest ? 2 : 1) * SizeOfVersion4(packed, n) +
                          sizeof(float) * (1 + n / 3)) {
    return damaged;
  }
  const auto take = packed ? TakePacked : TakeUnpacked;
  StoredBatch stored;
  if (has_largest) stored.batch.largest = take(n, bytes);
  ScorePart part = take(n, bytes);
  stored.batch.score = std::move(part.score);
  stored.batch.information = std::move(part.information);
  stored.evidence.log_output = TakeRaw<float>(bytes);
  for (std::size_t e = 0; e < n / 3; ++e) {
    stored.evidence.log_elements.push_back(TakeRaw<float>(bytes));
  }
  if (!IsSound(stored)) return damaged;
  return stored;
}

}  // namespace mle::watch
