// Stationary Kalman filter of an integrating disturbance on each output.
//
//   w_{l+1} = w_l + ξ_l,  Var ξ = ρ r;   z_l = w_l + v_l,  Var v = r,
//
// where z is measured less predicted output. The a-priori variance solves the
// Riccati equation P = P − P²/(P + r) + ρ r, so that P/r = (ρ + √(ρ² + 4ρ))/2
// and the gain is P/(P + r); ρ = 0.1 gives 0.27. (Anderson and Moore, Optimal
// Filtering, 1979, ch. 4.) ρ = 0 gives 0, no correction; ρ = ∞ gives 1, the
// plain bias update ŵ = z. The outputs' disturbances and noises are taken as
// independent, so that each output has a filter of its own, with its own ρ.

#ifndef CONTROL_DISTURBANCE_OBSERVER_H_
#define CONTROL_DISTURBANCE_OBSERVER_H_

#include "Eigen/Core"

namespace mle::control {

// Gain for the ratio ρ ∈ [0, ∞] of increment variance to noise variance.
double StationaryGain(double variance_ratio);

class DisturbanceObserver {
 public:
  // ρ of each output (p).
  explicit DisturbanceObserver(const Eigen::VectorXd& variance_ratios);

  const Eigen::VectorXd& gains() const { return gains_; }  // p
  // ŵ (p), the filtered disturbance.
  const Eigen::VectorXd& disturbance() const { return disturbance_; }
  // Sets ŵ.
  void Restart(const Eigen::Ref<const Eigen::VectorXd>& disturbance);

  // Takes the measured and the predicted outputs (p) of one instant. An output
  // whose measurement is not finite is taken as not measured: its ŵ stays.
  void Update(const Eigen::Ref<const Eigen::VectorXd>& measured,
              const Eigen::Ref<const Eigen::VectorXd>& predicted);

 private:
  Eigen::VectorXd gains_;
  Eigen::VectorXd disturbance_;
};

}  // namespace mle::control

#endif  // CONTROL_DISTURBANCE_OBSERVER_H_
