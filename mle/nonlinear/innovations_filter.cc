#include "mle/nonlinear/innovations_filter.h"

#include <cmath>

#include "glog/logging.h"

namespace mle {

InnovationsFilter::InnovationsFilter(const std::vector<int>& times,
                                     double ratio)
    : gains_(times.size()), inverse_roots_(times.size()) {
  CHECK_GE(ratio, 0.0);
  double filtered = 1.0;  // Variance of ŵ once the first sample has set it.
  for (std::size_t k = 1; k < times.size(); ++k) {
    const double predicted = filtered + ratio * (times[k] - times[k - 1]);
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
    double level = columns(0, c);
    columns(0, c) = 0.0;
    for (std::size_t k = 1; k < gains_.size(); ++k) {
      const double innovation = columns(k, c) - level;
      level += gains_[k] * innovation;
      columns(k, c) = innovation * inverse_roots_[k];
    }
  }
}

}  // namespace mle
