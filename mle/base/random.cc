#include "mle/base/random.h"

#include <array>

namespace mle {

std::mt19937_64 SeededEngine(std::uint64_t seed, std::uint64_t stream,
                             std::uint32_t substream) {
  const auto low = [](std::uint64_t x) {
    return static_cast<std::uint32_t>(x & 0xffffffffU);
  };
  const auto high = [](std::uint64_t x) {
    return static_cast<std::uint32_t>(x >> 32U);
  };
  const std::array<std::uint32_t, 5> words = {
      low(seed), high(seed), low(stream), high(stream), substream};
  std::seed_seq sequence(words.begin(), words.end());
  return std::mt19937_64(sequence);
}

double DrawUniform(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11U) * 0x1p-53;
}

GaussianNoise::GaussianNoise(std::uint64_t seed, std::uint64_t stream,
                             std::uint32_t substream)
    : engine_(SeededEngine(seed, stream, substream)) {}

double GaussianNoise::Draw(double standard_deviation) {
  return standard_deviation * normal_(engine_);
}

Eigen::MatrixXd GaussianNoise::DrawMatrix(int rows, int cols,
                                          double standard_deviation) {
  Eigen::MatrixXd draws(rows, cols);
  for (int j = 0; j < cols; ++j) {
    for (int i = 0; i < rows; ++i) draws(i, j) = Draw(standard_deviation);
  }
  return draws;
}

}  // namespace mle
