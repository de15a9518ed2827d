#include "mle/nonlinear/innovations_filter.h"

#include <cmath>

#include "glog/logging.h"

namespace mle {
namespace {

// Columns filtered at once: each sample waits for the one before, and
// recurrences that do not need each other fill the time.
constexpr Eigen::Index kTogether = 4;

// A product of F_k beyond this is exchanged for its logarithm: far from
// overflow, and one logarithm serves many samples.
constexpr double kLargeProduct = 1e100;

}  // namespace

InnovationsFilter::InnovationsFilter(const std::vector<int>& times,
                                     NoiseShape shape,
                                     const Eigen::VectorXd& weights)
    : gains_(times.size()),
      inverse_roots_(times.size()),
      smoothing_(times.size(), 1.0),
      offset_(shape.offset) {
  CHECK_GE(shape.ratio, 0.0);
  CHECK(weights.size() == 0 ||
        weights.size() == static_cast<Eigen::Index>(times.size()));
  const auto white = [&](std::size_t k) {
    return weights.size() > 0 ? 1.0 / weights(static_cast<Eigen::Index>(k))
                              : 1.0;
  };
  if (!shape.offset) {
    CHECK_EQ(shape.ratio, 0.0);
    for (std::size_t k = 0; k < times.size(); ++k) {
      inverse_roots_[k] = 1.0 / std::sqrt(white(k));
      if (weights.size() > 0) log_determinant_ += std::log(white(k));
    }
    return;
  }
  // Variance of ŵ once the first sample has set it.
  double filtered = times.empty() ? 0.0 : white(0);
  double product = 1.0;
  for (std::size_t k = 1; k < times.size(); ++k) {
    const double predicted = filtered + shape.ratio * (times[k] - times[k - 1]);
    const double variance = predicted + white(k);
    smoothing_[k - 1] = filtered / predicted;
    filtered = predicted * white(k) / variance;
    gains_[k] = predicted / variance;
    inverse_roots_[k] = 1.0 / std::sqrt(variance);
    product *= variance;
    if (product > kLargeProduct) {
      log_determinant_ += std::log(product);
      product = 1.0;
    }
  }
  log_determinant_ += std::log(product);
}

void InnovationsFilter::Apply(Eigen::Ref<Eigen::MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), static_cast<Eigen::Index>(gains_.size()));
  if (gains_.empty()) return;
  Eigen::Index c = 0;
  for (; c + kTogether <= columns.cols(); c += kTogether) {
    ApplyTo<kTogether>(columns.middleCols<kTogether>(c));
  }
  for (; c < columns.cols(); ++c) ApplyTo<1>(columns.middleCols<1>(c));
}

template <int kColumns, typename Columns>
void InnovationsFilter::ApplyTo(Columns&& columns) const {
  // With an offset the first sample sets the level.
  double level[kColumns];
  for (int c = 0; c < kColumns; ++c) level[c] = offset_ ? columns(0, c) : 0.0;
  for (std::size_t k = 0; k < gains_.size(); ++k) {
    for (int c = 0; c < kColumns; ++c) {
      const double innovation = columns(k, c) - level[c];
      level[c] += gains_[k] * innovation;
      columns(k, c) = innovation * inverse_roots_[k];
    }
  }
}

Eigen::VectorXd InnovationsFilter::WhitePart(
    const Eigen::VectorXd& disturbance) const {
  CHECK_EQ(disturbance.size(), static_cast<Eigen::Index>(gains_.size()));
  if (!offset_ || disturbance.size() == 0) return disturbance;
  Eigen::VectorXd level(disturbance.size());
  level(0) = disturbance(0);
  for (Eigen::Index k = 1; k < level.size(); ++k) {
    level(k) = level(k - 1) + gains_[k] * (disturbance(k) - level(k - 1));
  }
  for (Eigen::Index k = level.size() - 2; k >= 0; --k) {
    level(k) += smoothing_[k] * (level(k + 1) - level(k));
  }
  return disturbance - level;
}

}  // namespace mle
