// The exact change of a linear system's state over a time in which its input is
// held:
//
//   ẋ = A x + B u:   x ← x + E x + Γ u,
//   E = e^{Aτ} − I,  Γ = ∫₀^τ e^{As} ds B.
//
// By scaling and squaring: the Taylor series of φ(X) = (e^X − I)/X over τ/2^s,
// where ‖A‖₁τ/2^s ≤ ½, then s doublings E ← 2E + E², Γ ← 2Γ + EΓ. E is kept
// instead of e^{Aτ}, because over a short time the latter loses the slow modes
// to rounding: modes many decades apart keep their digits.
//
//   const HeldInputMap map = HeldInputMap::Over(0.2, system.A, system.B);
//   x += map.E * x + map.gamma * u;
//
// A should be balanced, as TransferFunction::Realize() gives it. (Higham,
// Functions of Matrices, 2008, §10.3 and §10.7.4.)

#ifndef MLE_MODEL_HELD_INPUT_MAP_H_
#define MLE_MODEL_HELD_INPUT_MAP_H_

#include "Eigen/Core"

namespace mle {

struct HeldInputMap {
  Eigen::MatrixXd E;      // r × r
  Eigen::VectorXd gamma;  // r

  // Over `duration` τ ≥ 0, for A: r × r, B: r. Not finite where ‖A‖₁ is not.
  static HeldInputMap Over(double duration, const Eigen::MatrixXd& A,
                           const Eigen::VectorXd& B);
};

// One sample in which the input before is seen for the first part of the time:
//
//   x ← x + E x + b_older u_older + b_newer u_newer.
struct SampleMap {
  Eigen::MatrixXd E;      // r × r
  Eigen::VectorXd older;  // b_older: r
  Eigen::VectorXd newer;  // b_newer: r

  // The sample takes `sample_time` ≥ 0, the first part `fraction` f of it, in
  // [0, 1].
  static SampleMap Over(double sample_time, double fraction,
                        const Eigen::MatrixXd& A, const Eigen::VectorXd& B);
};

}  // namespace mle

#endif  // MLE_MODEL_HELD_INPUT_MAP_H_
