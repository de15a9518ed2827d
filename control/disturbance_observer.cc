#include "control/disturbance_observer.h"

#include <cmath>

#include "glog/logging.h"

namespace mle::control {

double StationaryGain(double variance_ratio) {
  CHECK_GE(variance_ratio, 0.0);
  if (variance_ratio == 0.0) return 0.0;
  // P/(P + r) for the P above, in a form that neither cancels nor overflows.
  return 2.0 / (1.0 + std::sqrt(1.0 + 4.0 / variance_ratio));
}

DisturbanceObserver::DisturbanceObserver(const Eigen::VectorXd& variance_ratios,
                                         const std::vector<bool>& integrating)
    : gains_(variance_ratios.unaryExpr(&StationaryGain)),
      slope_gains_(Eigen::VectorXd::Zero(variance_ratios.size())),
      disturbance_(slope_gains_),
      slope_(slope_gains_) {
  CHECK(integrating.empty() ||
        std::ssize(integrating) == variance_ratios.size());
  for (std::size_t i = 0; i < integrating.size(); ++i) {
    if (!integrating[i]) continue;
    const auto at = static_cast<Eigen::Index>(i);
    // 1 − √(1 − g) without cancellation.
    const double part = gains_[at] / (1.0 + std::sqrt(1.0 - gains_[at]));
    slope_gains_[at] = part * part;
  }
}

void DisturbanceObserver::Restart(
    const Eigen::Ref<const Eigen::VectorXd>& disturbance,
    const Eigen::Ref<const Eigen::VectorXd>& slope) {
  CHECK_EQ(disturbance.size(), disturbance_.size());
  CHECK_EQ(slope.size(), slope_.size());
  disturbance_ = disturbance;
  slope_ = slope;
}

void DisturbanceObserver::Update(
    const Eigen::Ref<const Eigen::VectorXd>& measured,
    const Eigen::Ref<const Eigen::VectorXd>& predicted) {
  for (Eigen::Index i = 0; i < disturbance_.size(); ++i) {
    if (!std::isfinite(measured[i])) continue;
    const double innovation = measured[i] - predicted[i] - disturbance_[i];
    disturbance_[i] += gains_[i] * innovation;
    slope_[i] += slope_gains_[i] * innovation;
  }
}

}  // namespace mle::control
