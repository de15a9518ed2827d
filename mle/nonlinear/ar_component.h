// Stationary noise with one pole or a pair of them, sampled. Internal to
// mle/nonlinear and to who draws such noise.
//
//   first order, ζ = 0:   a_{k+1} = φ a_k + η_k,   Var η = s;
//   second order, ζ > 0:  (1 − p₁B)(1 − p₂B) a_k = η_{k−2},
//                         p = exp(−ω (ζ ± √(ζ² − 1))),   ω = −ln φ,
//
// where 1/ω is the natural time constant in samples and ζ the damping. With
// ζ ≥ 1 an autoregression of first order has passed a lag of first order, as a
// load at an input does on its way through an element; with ζ < 1 it resonates.
// The second order has two states, with μ = (p₁ + p₂)/2 and D = (p₁ − p₂)²/4,
//
//   (a, b)_{k+1} = F (a, b)_k + (0, η_k),   F = μ + N,   N = (0 1; D 0).
//
// N² = D, so that every power of F is m + c N with numbers m and c; for real
// poles no entry is negative, and no digits are lost.

#ifndef MLE_NONLINEAR_AR_COMPONENT_H_
#define MLE_NONLINEAR_AR_COMPONENT_H_

#include "Eigen/Core"
#include "mle/base/random.h"

namespace mle {

class ArComponent {
 public:
  // φ in [0, 1); ζ ≥ 0, finite. White noise by default.
  explicit ArComponent(double pole = 0.0, double damping = 0.0);

  int order() const { return second_order_ ? 2 : 1; }
  double spread() const { return spread_; }  // D; 0 of first order

  // F^d, d ≥ 0; of first order c is 0.
  struct Power {
    double own = 1.0;    // m
    double cross = 0.0;  // c
  };
  Power After(int steps) const;

  // Var a, Cov(a, b) and Var b for s = 1; the last two are 0 of first order.
  struct Covariance {
    double aa = 1.0;
    double ab = 0.0;
    double bb = 0.0;
  };
  Covariance Stationary() const;

 private:
  bool second_order_ = false;
  double centre_ = 0.0;  // μ, or φ
  double spread_ = 0.0;
  double gap_ = 1.0;  // (1 − p₁)(1 − p₂)
};

// Draws a_0, a_1, … with shocks of variance s.
class ArSignal {
 public:
  ArSignal(const ArComponent& ar, double shock_variance, GaussianNoise& random);

  double value() const { return a_; }
  void Advance();

 private:
  ArComponent::Power step_;
  double spread_ = 0.0;
  bool second_order_ = false;
  double deviation_ = 0.0;
  GaussianNoise& random_;
  double a_ = 0.0;
  double b_ = 0.0;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_AR_COMPONENT_H_
