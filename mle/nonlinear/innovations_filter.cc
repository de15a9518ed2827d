#include "mle/nonlinear/innovations_filter.h"

#include <cmath>

#include "glog/logging.h"

namespace mle {

InnovationsFilter::InnovationsFilter(const std::vector<int>& times,
                                     NoiseShape shape)
    : gains_(times.size()), inverse_roots_(times.size()) {
  CHECK_GE(shape.ratio, 0.0);
  if (!shape.offset) {
    CHECK_EQ(shape.ratio, 0.0);
    inverse_roots_.assign(times.size(), 1.0);
    return;
  }
  double filtered = 1.0;  // Variance of ŵ once the first sample has set it.
  for (std::size_t k = 1; k < times.size(); ++k) {
    const double predicted = filtered + shape.ratio * (times[k] - times[k - 1]);
    const double variance = predicted + 1.0;
    filtered = predicted / variance;
    gains_[k] = filtered;
    inverse_roots_[k] = 1.0 / std::sqrt(variance);
    log_determinant_ += std::log(variance);
  }
}

void InnovationsFilter::Apply(Eigen::Ref<Eigen::MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), static_cast<Eigen::Index>(gains_.size()));
  if (gains_.empty()) return;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    // With an offset the first sample sets the level.
    double level = inverse_roots_[0] == 0.0 ? columns(0, c) : 0.0;
    for (std::size_t k = 0; k < gains_.size(); ++k) {
      const double innovation = columns(k, c) - level;
      level += gains_[k] * innovation;
      columns(k, c) = innovation * inverse_roots_[k];
    }
  }
}

}  // namespace mle
