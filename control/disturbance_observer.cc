#include "control/disturbance_observer.h"

#include <cmath>

#include "Eigen/QR"
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

DisturbanceObserver::DisturbanceObserver(const DisturbanceForm& model,
                                         int horizon)
    : gains_(Eigen::VectorXd::Zero(model.C.rows())),
      slope_gains_(gains_),
      disturbance_(gains_),
      slope_(gains_),
      model_(model),
      state_(Eigen::VectorXd::Zero(model.A.rows())),
      next_(state_),
      innovation_(gains_),
      forecasts_(model.C.rows() * horizon, model.A.cols()) {
  const Eigen::Index p = model.C.rows();
  Eigen::MatrixXd rows = model.C;
  for (int i = 0; i < horizon; ++i) {
    forecasts_.middleRows(i * p, p) = rows;
    rows = (rows * model.A).eval();
  }
}

void DisturbanceObserver::AddForecast(
    int i, Eigen::Ref<Eigen::VectorXd> outputs) const {
  if (has_model()) {
    const Eigen::Index p = outputs.size();
    outputs.noalias() += forecasts_.middleRows((i - 1) * p, p) * state_;
  } else {
    outputs += disturbance_ + i * slope_;
  }
}

void DisturbanceObserver::Advance() {
  if (has_model()) {
    disturbance_.noalias() = model_.C * state_;
  } else {
    disturbance_ += slope_;
  }
}

void DisturbanceObserver::Restart(
    const Eigen::Ref<const Eigen::VectorXd>& disturbance,
    const Eigen::Ref<const Eigen::VectorXd>& slope) {
  CHECK_EQ(disturbance.size(), disturbance_.size());
  CHECK_EQ(slope.size(), slope_.size());
  disturbance_ = disturbance;
  slope_ = slope;
  if (!has_model()) return;
  // The state at rest, A d = d, C d = ŵ.
  const Eigen::Index n = state_.size();
  const Eigen::Index p = disturbance.size();
  Eigen::MatrixXd rows(n + p, n);
  rows << model_.A - Eigen::MatrixXd::Identity(n, n), model_.C;
  Eigen::VectorXd values = Eigen::VectorXd::Zero(n + p);
  values.tail(p) = disturbance;
  state_ = rows.colPivHouseholderQr().solve(values);
  disturbance_ = model_.C * state_;
}

void DisturbanceObserver::Update(
    const Eigen::Ref<const Eigen::VectorXd>& measured,
    const Eigen::Ref<const Eigen::VectorXd>& predicted) {
  if (has_model()) {
    innovation_ = measured - predicted - disturbance_;
    for (double& value : innovation_) {
      if (!std::isfinite(value)) value = 0.0;
    }
    next_.noalias() = model_.A * state_;
    next_.noalias() += model_.K * innovation_;
    state_.swap(next_);
    return;
  }
  for (Eigen::Index i = 0; i < disturbance_.size(); ++i) {
    if (!std::isfinite(measured[i])) continue;
    const double innovation = measured[i] - predicted[i] - disturbance_[i];
    disturbance_[i] += gains_[i] * innovation;
    slope_[i] += slope_gains_[i] * innovation;
  }
}

}  // namespace mle::control
