// The filter of a step-response controller: one bias for each output,
//
//   ŵ_l = ŵ_{l−1} + g (z_l − ŵ_{l−1}),   prediction of z_{l+h}: ŵ_l,
//
// at its control instants; g = 1 is the plain bias update of dynamic matrix
// control, and −Δt_c / ln(1 − g) the time constant of the filter. Of a random
// walk (increments of variance q), a coloured component with covariances γ_k
// and white noise (r), the error of ŵ_l is, with θ = 1 − g,
//
//   Var(ŵ − w) = (θ² q + g² r + g² (γ_0 + 2 Σ_{k≥1} θ^k γ_k)) / (1 − θ²),
//   E (z_{l+h} − ŵ_l)² = Var(ŵ − w) + h q + γ_0 + r − 2 g Σ_{k≥0} θ^k γ_{h+k}.
//
// Internal to mle/filter.

#ifndef MLE_FILTER_BIAS_FILTER_H_
#define MLE_FILTER_BIAS_FILTER_H_

#include "mle/filter/disturbance_system.h"

namespace mle {

// The mean of E (z_{l+h} − ŵ_l)² over h = 1 … `horizon`, in samples of the
// system; 0 < g ≤ 1.
double BiasFilterError(const DisturbanceSystem& system, double gain,
                       int horizon);

// The gain with the least mean error. ≥ 1e-6: a filter that followed nothing
// would leave an offset for ever.
double BestBiasGain(const DisturbanceSystem& system, int horizon);

}  // namespace mle

#endif  // MLE_FILTER_BIAS_FILTER_H_
