#include "mle/maintain/play_filters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace mle {
namespace {

// `samples` later, or earlier if negative.
Eigen::VectorXd Shifted(const Eigen::VectorXd& values, int samples) {
  const auto n = static_cast<int>(values.size());
  Eigen::VectorXd shifted(n);
  for (int k = 0; k < n; ++k) {
    shifted(k) = values(std::clamp(k - samples, 0, n - 1));
  }
  return shifted;
}

// Through a first-order lag of `time` samples, settled at the first value.
Eigen::VectorXd Lagged(const Eigen::VectorXd& values, double time) {
  const double share = -std::expm1(-1.0 / time);
  Eigen::VectorXd lagged(values.size());
  double state = values(0);
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    state += share * (values(k) - state);
    lagged(k) = state;
  }
  return lagged;
}

}  // namespace

std::array<Eigen::VectorXd, kPlayFilters> ThroughPlayFilters(
    const TransferFunction& element, double sample_time,
    const Eigen::VectorXd& values) {
  const auto delay = static_cast<int>(element.delay() / sample_time);
  const double time =
      std::max(2.0, element.SlowestTimeConstant() / sample_time);
  return {values,
          Shifted(values, -delay),
          Shifted(values, -(delay / 2)),
          Lagged(values, time / 8.0 + 1.0),
          Lagged(values, time / 2.0),
          Lagged(values, 2.0 * time)};
}

Eigen::VectorXd InnovationsOfDrift(const Eigen::VectorXd& values,
                                   double share) {
  Eigen::VectorXd rest(values.size());
  double level = values(0);
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    rest(k) = values(k) - level;
    level += share * rest(k);
  }
  return rest;
}

WhitenedData InnovationsOfDrift(WhitenedData data, double share) {
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    data.outputs[w] = InnovationsOfDrift(data.outputs[w], share);
    for (Eigen::Index c = 0; c < data.responses[w].cols(); ++c) {
      if (data.responses[w].col(c).isZero(0.0)) continue;
      data.responses[w].col(c) =
          InnovationsOfDrift(data.responses[w].col(c), share);
    }
  }
  return data;
}

}  // namespace mle
