// The filter of a step-response controller: one bias for each output,
//
//   ŵ_l = ŵ_{l−1} + g (z_l − ŵ_{l−1}),   prediction of z_{l+h}: ŵ_l,
//
// at its control instants; g = 1 is the plain bias update of dynamic matrix
// control, and −Δt_c / ln(1 − g) the time constant of the filter. With the walk
// w and what decays, y (Separate()), δ = ŵ − w and y are stationary,
//
//   δ_l = (1 − g) (δ_{l−1} − ξ_{l−1}) + g (C y_l + v_l),   y_l = B y_{l−1} +
//   η_{l−1},
//
// and the error of a prediction is
//
//   z_{l+h} − ŵ_l = C B^h y_l − δ_l + Σ_{i<h} (ξ_{l+i} + C B^{h−1−i} η_{l+i}) +
//   v.
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
