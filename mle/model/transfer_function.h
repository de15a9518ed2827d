// One input–output pair of a process: a proper rational transfer function with
// a dead time,
//
//   g(s) = e^{-Ls} (b_0 s^q + … + b_q) / (a_0 s^r + … + a_r),   q ≤ r, L ≥ 0,
//
// stable, or integrating: with one pole at s = 0 (a level, a pressure, an
// inventory) and all others stable. The order of integration ν is 0 or 1, and
// the gain is
//
//   K = lim_{s→0} s^ν g(s):
//
// where the response to a unit step settles (ν = 0), or the slope of the ramp
// that it ends in (ν = 1), per unit of time. Time is in the unit of the process
// model the element belongs to.
//
//   const auto g = TransferFunction::FirstOrder(12.8, 16.7, 1.0);
//   g.StaticGain();                       // 12.8
//   g.StepResponse(/*sample_time=*/0.2, /*samples=*/501);

#ifndef MLE_MODEL_TRANSFER_FUNCTION_H_
#define MLE_MODEL_TRANSFER_FUNCTION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle {

// ẋ = A x + B u(t − L),  y = C x + D u(t − L); r states, one input, one output.
// Controllable companion form with the denominator made monic and its states
// scaled by powers of two, so that rows and columns of A are of like size (the
// companion form itself loses digits in any unit of time but its own).
struct StateSpace {
  Eigen::MatrixXd A;     // r × r
  Eigen::VectorXd B;     // r
  Eigen::RowVectorXd C;  // r
  double D = 0.0;
};

class TransferFunction {
 public:
  // The zero element: its input does not reach its output.
  TransferFunction() = default;

  // Coefficients in s, highest power first. Call Validate() on what comes from
  // outside; the other members expect a valid element.
  TransferFunction(std::vector<double> numerator,
                   std::vector<double> denominator, double delay);

  // K e^{-Ls} / (T s + 1).
  static TransferFunction FirstOrder(double gain, double time_constant,
                                     double delay);

  // K e^{-Ls} / (s (T s + 1)); T = 0: K e^{-Ls} / s.
  static TransferFunction Integrator(double gain, double time_constant,
                                     double delay);

  // Finite coefficients, a leading denominator coefficient other than zero,
  // q ≤ r, L ≥ 0, every pole in the open left half-plane but for at most one at
  // s = 0, where the numerator is not zero; dead time and slowest time constant
  // together at most 1e300.
  absl::Status Validate() const;

  bool IsZero() const;
  // ν: a_r is 0, to the last bit. Of the zero element 0.
  int IntegrationOrder() const;
  bool IsIntegrating() const { return IntegrationOrder() > 0; }
  // A stable first-order element without zeros, whose gain and time constant
  // are K, T.
  bool IsFirstOrder() const;
  // An integrating element without zeros and with one lag at most.
  bool IsIntegratorWithLag() const;

  const std::vector<double>& numerator() const { return numerator_; }
  const std::vector<double>& denominator() const { return denominator_; }
  double delay() const { return delay_; }
  void set_delay(double delay) { delay_ = delay; }

  // K = lim s^ν g(s): of an integrating element a slope.
  double StaticGain() const;
  // T of a first-order element, or of the lag of an integrator (0: none).
  double TimeConstant() const;
  // −1 / (largest real part of a pole other than s = 0): the slowest mode's
  // time constant; 0 for a static element and for an integrator without lag.
  double SlowestTimeConstant() const;
  // L + Σ T_k + 4 √Σ T_k², T_k = −1 / Re s_k of every pole but one at s = 0:
  // the mean of the impulse response of such lags one behind the other and four
  // of its standard deviations, L + 5 T of a single one. All but 1 % of a step
  // response has then passed, also of many equal lags.
  double TimeToSettle() const;

  StateSpace Realize() const;

  // h(kΔt), k = 0 … samples−1, the response to a unit step at t = 0, exact to
  // rounding (held_input_map.h). Samples are taken just before the input
  // changes: h(t) = 0 for t ≤ L, also where the element has feedthrough.
  Eigen::VectorXd StepResponse(double sample_time, int samples) const;

 private:
  std::vector<double> numerator_ = {0.0};
  std::vector<double> denominator_ = {1.0};
  double delay_ = 0.0;
};

// The fitted values of an element. Time is in the process model's unit.
struct ElementValues {
  double gain = 0.0;        // K
  double time_scale = 1.0;  // T > 0, without a meaning where there is no lag
  double delay = 0.0;       // L ≥ 0
};

}  // namespace mle

#endif  // MLE_MODEL_TRANSFER_FUNCTION_H_
