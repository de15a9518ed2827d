// The response of one output to a change of set points: losses of predictions
// over all of it, in rows k of a window around the change.
//
// With the plain bias update at the row k = 0 the errors of the predictions of
// the rows that follow are e_k − e_0. What noise makes of them is known from
// its variogram G(l) = E (n_{k+l} − n_k)²/2 at rest, which also exists of noise
// that drifts: with any weights w that add up to 0
//
//   Var wᵀn = −Σ_kl w_k w_l G(|k − l|) = wᵀ Γ w,
//
// and the loss of the residuals is that of all errors together, each direction
// in units of what noise makes of it,
//
//   L(e) = eᵀ W e,   W = (P Γ P + δ I)⁺,   P = I − 1 1ᵀ/n,
//
// δ a share of the mean of its eigenvalues, negative ones taken as 0.
// Internal to mle/trial.

#ifndef MLE_TRIAL_CHANGE_WINDOW_H_
#define MLE_TRIAL_CHANGE_WINDOW_H_

#include <vector>

#include "Eigen/Core"
#include "mle/trial/trial_state.h"

namespace mle {

// W (n × n). `known` (n): other rows have no weight. Zero without noise.
Eigen::MatrixXd LossMatrix(const Variogram& noise,
                           const std::vector<bool>& known);

// How two models do in a response of an output.
struct OutputComparison {
  double gain = 0.0;       // D = zᵀW (e⁰ + e¹)/2
  double size = 0.0;       // zᵀW z
  double deviation = 0.0;  // σ(D); 0: not judged
  // L(e) less the least L(e − shapesᵀc), less the q that this is of noise
  // alone: what set points drive of e⁰ and of e¹.
  double in_use = 0.0;
  double proposed = 0.0;
  bool compared = false;  // with enough rows and noise for the last two
};

// `rest`: the noise at rest; where that is too short `always` stands for it, of
// all rows. `in_use`, `proposed` (n): e⁰ and e¹, NaN where they are not known;
// `driven` (n): z; `shapes`: q × n.
OutputComparison CompareOutput(const Variogram& rest, const Variogram& always,
                               const Eigen::VectorXd& in_use,
                               const Eigen::VectorXd& proposed,
                               const Eigen::VectorXd& driven,
                               const Eigen::MatrixXd& shapes);

}  // namespace mle

#endif  // MLE_TRIAL_CHANGE_WINDOW_H_
