// Which parameters of elements that have changed have changed themselves, and
// how much parameters of a plant change at all, is integrated over. Internal to
// mle/nonlinear.
//
// A fit says θ̂ ~ N(θ₀ + δ, V). A valve that wears takes an element's gain and
// leaves its time constant; records of one window often tell K and T from each
// other badly, and the fit then moves both. The prior of each δ_k is therefore
// a mixture of four normal distributions, independent of the others,
//
//   δ_k ~ Σ_s π_s N(0, (σ_s u_k)²),   σ = 0.02, 0.2, 0.6, 2,   π = ½, ⅙, ⅙, ⅙,
//
// u = |K₀|, T₀ and T₀ + L₀: a parameter that has stayed (2 % of it do not
// matter) and three that have changed, by unlike amounts. (The spike and slabs
// of George and McCulloch, JASA 88, 1993.) For each choice s of one σ for each
// parameter, with D = diag((σ_s u)²) and d = θ̂ − θ₀,
//
//   weight ∝ Π π_s N(d; 0, V + D),   E δ = D (V + D)⁻¹ d,   Var δ = D − D (V +
//   D)⁻¹ D.

#ifndef MLE_NONLINEAR_CHANGE_PRIOR_H_
#define MLE_NONLINEAR_CHANGE_PRIOR_H_

#include <vector>

#include "mle/nonlinear/output_fit.h"

namespace mle {

// The estimates under each choice that matters, heaviest first, as changes from
// `fit`; weights add up to one. Choices are visited best first from the one
// that suits each parameter alone, by changes of one parameter's σ at a time:
// at most 300 visits of O(n³ + n) operations for n parameters. Left out are
// those past 99.9 % of the weight, and past the 64 heaviest. What the records
// do not determine (infinite variance) is no part of this and stays as in
// `fit`.
std::vector<LinearEstimate> IntegrateChanges(const OutputFit& fit,
                                             const OutputPoint& initial);

// −2 ln of the density of the change d/u of a parameter that has changed, by
// the three widest σ, over that of none; ≥ 0.
double Improbability(double change);

}  // namespace mle

#endif  // MLE_NONLINEAR_CHANGE_PRIOR_H_
