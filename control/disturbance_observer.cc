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

DisturbanceObserver::DisturbanceObserver(int num_outputs, double variance_ratio)
    : gain_(StationaryGain(variance_ratio)),
      disturbance_(Eigen::VectorXd::Zero(num_outputs)) {}

void DisturbanceObserver::Update(
    const Eigen::Ref<const Eigen::VectorXd>& measured,
    const Eigen::Ref<const Eigen::VectorXd>& predicted) {
  disturbance_ += gain_ * (measured - predicted - disturbance_);
}

}  // namespace mle::control
