#include "mle/nonlinear/innovations_filter.h"

#include <cmath>

#include "glog/logging.h"

namespace mle {

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
  for (std::size_t k = 1; k < times.size(); ++k) {
    const double predicted = filtered + shape.ratio * (times[k] - times[k - 1]);
    const double variance = predicted + white(k);
    smoothing_[k - 1] = filtered / predicted;
    filtered = predicted * white(k) / variance;
    gains_[k] = predicted / variance;
    inverse_roots_[k] = 1.0 / std::sqrt(variance);
    log_determinant_ += std::log(variance);
  }
}

void InnovationsFilter::Apply(Eigen::Ref<Eigen::MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), static_cast<Eigen::Index>(gains_.size()));
  if (gains_.empty()) return;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    // With an offset the first sample sets the level.
    double level = offset_ ? columns(0, c) : 0.0;
    for (std::size_t k = 0; k < gains_.size(); ++k) {
      const double innovation = columns(k, c) - level;
      level += gains_[k] * innovation;
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
