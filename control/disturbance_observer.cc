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

DisturbanceObserver::DisturbanceObserver(const Eigen::VectorXd& variance_ratios)
    : gains_(variance_ratios.unaryExpr(&StationaryGain)),
      disturbance_(Eigen::VectorXd::Zero(variance_ratios.size())) {}

void DisturbanceObserver::Restart(
    const Eigen::Ref<const Eigen::VectorXd>& disturbance) {
  CHECK_EQ(disturbance.size(), disturbance_.size());
  disturbance_ = disturbance;
}

void DisturbanceObserver::Update(
    const Eigen::Ref<const Eigen::VectorXd>& measured,
    const Eigen::Ref<const Eigen::VectorXd>& predicted) {
  for (Eigen::Index i = 0; i < disturbance_.size(); ++i) {
    if (!std::isfinite(measured[i])) continue;
    disturbance_[i] +=
        gains_[i] * (measured[i] - predicted[i] - disturbance_[i]);
  }
}

}  // namespace mle::control
