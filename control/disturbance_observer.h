// Filter of a disturbance on each output: a random walk, and of an integrating
// output a ramp.
//
//   w_{l+1} = w_l + ξ_l,  Var ξ = ρ r;   z_l = w_l + v_l,  Var v = r,
//
// where z is measured less predicted output. The a-priori variance solves the
// Riccati equation P = P − P²/(P + r) + ρ r, so that P/r = (ρ + √(ρ² + 4ρ))/2
// and the gain is P/(P + r); ρ = 0.1 gives 0.27. (Anderson and Moore, Optimal
// Filtering, 1979, ch. 4.) ρ = 0 gives 0, no correction; ρ = ∞ gives 1, the
// plain bias update ŵ = z. The outputs' disturbances and noises are taken as
// independent, so that each output has a filter of its own, with its own ρ.
//
// A load at an input of an integrating output is a ramp of that output. There
//
//   w_{l+1} = w_l + d_l,   ŵ ← ŵ + g (z − ŵ),   d̂ ← d̂ + h (z − ŵ),
//
// with the gain g of above and h = (1 − √(1 − g))²: both poles of the filter
// then are at θ = √(1 − g), the fading-memory filter with g = 1 − θ²,
// h = (1 − θ)². (Brookner, Tracking and Kalman Filtering Made Easy, 1998, ch. 1
// and 7.)
//
// Instead of these, outputs that do not integrate may have a disturbance model
// (DisturbanceForm, state_space.h) at the control instants, as mle_correct
// finds it,
//
//   d̂ ← A d̂ + K (z − C d̂),   forecast i instants ahead C A^{i−1} d̂,
//
// which, other than a walk, may return to its mean, or go on rising for a
// while.

#ifndef CONTROL_DISTURBANCE_OBSERVER_H_
#define CONTROL_DISTURBANCE_OBSERVER_H_

#include <vector>

#include "Eigen/Core"
#include "mle/model/state_space.h"

namespace mle::control {

// Gain for the ratio ρ ∈ [0, ∞] of increment variance to noise variance.
double StationaryGain(double variance_ratio);

class DisturbanceObserver {
 public:
  // ρ of each output (p); outputs that are `integrating` (empty: none) may have
  // ramps.
  explicit DisturbanceObserver(const Eigen::VectorXd& variance_ratios,
                               const std::vector<bool>& integrating = {});

  // Of a valid model of all outputs (p), for forecasts up to `horizon`
  // instants.
  DisturbanceObserver(const DisturbanceForm& model, int horizon);

  bool has_model() const { return model_.A.size() > 0; }
  const Eigen::VectorXd& gains() const { return gains_; }  // p, g
  // p, h: 0 of outputs without ramps.
  const Eigen::VectorXd& slope_gains() const { return slope_gains_; }
  // ŵ (p), the filtered disturbance; after Advance() the one expected at the
  // coming instant.
  const Eigen::VectorXd& disturbance() const { return disturbance_; }
  // d̂ (p), what ŵ grows by from one instant to the next.
  const Eigen::VectorXd& slope() const { return slope_; }
  // Adds what is expected i ≥ 1 instants after the last Update() to `outputs`
  // (p).
  void AddForecast(int i, Eigen::Ref<Eigen::VectorXd> outputs) const;
  // Sets ŵ and d̂; of a model the state that stays, if it has one.
  void Restart(const Eigen::Ref<const Eigen::VectorXd>& disturbance,
               const Eigen::Ref<const Eigen::VectorXd>& slope);

  // Takes the measured and the predicted outputs (p) of one instant. An output
  // whose measurement is not finite is taken as not measured: its ŵ stays.
  void Update(const Eigen::Ref<const Eigen::VectorXd>& measured,
              const Eigen::Ref<const Eigen::VectorXd>& predicted);
  // On to the next instant: ŵ ← ŵ + d̂.
  void Advance();

 private:
  Eigen::VectorXd gains_;
  Eigen::VectorXd slope_gains_;
  Eigen::VectorXd disturbance_;
  Eigen::VectorXd slope_;
  DisturbanceForm model_;       // empty: none
  Eigen::VectorXd state_;       // n: d̂ of the coming instant
  Eigen::VectorXd next_;        // n
  Eigen::VectorXd innovation_;  // p
  // C A^{i−1}, i = 1 …, one below the other: p·horizon × n.
  Eigen::MatrixXd forecasts_;
};

}  // namespace mle::control

#endif  // CONTROL_DISTURBANCE_OBSERVER_H_
