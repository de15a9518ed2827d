// The behaviour of a predictive controller on a plant that its model knows only
// roughly: stability and sensitivity of the loop without limits.
//
// In w = z⁻¹, with Δu(w) the moves, decided at l and acting from l+1, P_k the
// plant's step responses, S_k the model's, K_i the gain's blocks, and W_i what
// the observer (disturbance_observer.h) makes of measured less predicted
// outputs i periods ahead:
//
//   y = P(w) Δu + d,   P(w) = Σ_{a≥1} P_{a−1} w^a,
//   Δu = Σ K_i (r − F_i Δu − W_i (y − F_0 Δu)),
//   F_i(w) = Σ_{a≥1} S_{a+i−1} w^a.
//
// W_i is diagonal: g / (1 − (1 − g) w), and of outputs that integrate, with
// θ² = 1 − g and h = (1 − θ)²,
//
//   1 − (1 − g)(1 − w)²/(1 − θw)² + i h (1 − w)/(1 − θw)².
//
// With V = Σ K_i W_i the loop's modes are the inverses of the zeros of
// det(I + Σ K_i (F_i − W_i F_0) + V P), whose poles and zeros at w = 1 would
// hide those near it: responses that settle have sums with a pole there, and
// each of m − p inputs that the outputs leave free adds a zero, a sum of moves
// that nothing asks back. Both are taken out before anything is computed. With
// S_k = L + kR + C_k, of which C_k decays, c_i = Σ_{a≥1} C_{a+i−1} w^a and
// v = 1 − w,
//
//   F_i − W_i F_0 = (1 − W_i) (w/v L + w²/v² R) + i w/v R + c_i − W_i c_0,
//
// where what stands before L and R has no pole (φ, … in loop_analysis.cc), and
// with d = v, G = L, of outputs with ramps d = v², G = R + v (L − 2R), of the
// plant
//
//   P = diag(d)⁻¹ G + R − L + c_P.
//
// The modes are then the inverses of the zeros of
//
//   D(w) = v^{−s} det [ B  V ; −G  diag(d) ],
//   B = I + Σ K_i (F_i − W_i F_0) + V (R − L + c_P),
//
// s = 0 but where outputs are more than inputs: p − m where none has a ramp.
// D has no poles in |w| ≤ 1, so that they are counted by the argument
// principle, as in Nyquist's criterion, on the sampled responses themselves.
// The sensitivity S = (I + P C)⁻¹ tells how much the loop amplifies a
// disturbance of each frequency, C being the controller from −y to Δu; 1/‖S‖_∞
// is the distance of the loop from instability (Skogestad and Postlethwaite,
// Multivariable Feedback Control, 2005, sec. 2.4.3, who ask for a peak below
// 2). Outputs are scaled by the roots of their weights Q_y,ii, so that units do
// not matter.
//
//   MLE_ASSIGN_OR_RETURN(const LoopAnalysis loop, AnalyseLoop(mpc, plant));

#ifndef CONTROL_LOOP_ANALYSIS_H_
#define CONTROL_LOOP_ANALYSIS_H_

#include <string>

#include "absl/status/statusor.h"
#include "control/mpc.h"
#include "control/prediction_model.h"

namespace mle::control {

// Responses that settle later are not analysed, in control periods n. A count
// of zeros costs O(m² n log n + n (m + p)³): a Fourier transform for each two
// inputs, and an elimination for each point of the circle.
inline constexpr int kMostAnalysedPeriods = 50'000;

struct LoopAnalysis {
  // No mode grows. Inputs that are more than the outputs leave as many modes
  // that neither grow nor decay; they count as stable.
  bool stable = false;
  int growing_modes = 0;
  // The largest magnitude of a mode, per control period. Modes that decay
  // faster than the plant itself are not told apart: then this is an upper
  // bound, near that of the plant's slowest mode.
  double spectral_radius = 0.0;
  // max_ω σ_max(S) and max_ω σ_max(I − S); meaningful for a stable loop.
  double sensitivity_peak = 0.0;
  double complementary_peak = 0.0;
  // Where S peaks, in rad per time unit.
  double peak_frequency = 0.0;

  // "stable, slowest mode 0.95 per period, sensitivity peak 1.3"
  std::string Brief() const;
};

// The fastest growing mode of an unstable loop is searched for, by many counts,
// only if `find_fastest`; else spectral_radius is infinite.
//
// InvalidArgument if the plant has another control period, or other numbers or
// roles of inputs and outputs, than the controller, or a response settles too
// late. FailedPrecondition if rounding leaves nothing of D.
absl::StatusOr<LoopAnalysis> AnalyseLoop(const Mpc& mpc,
                                         const PredictionModel& plant,
                                         bool find_fastest = true);

}  // namespace mle::control

#endif  // CONTROL_LOOP_ANALYSIS_H_
