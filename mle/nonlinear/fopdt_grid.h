// The start for the fit of a first-order-plus-dead-time element, by variable
// projection on a grid of time constants. Internal to fopdt_fit.
//
// Time is in samples here: h_k = K (1 − e^{−(k−L)/T}) for k > L, else 0. For L
// in the sample before k₀, (k₀−1 ≤ L < k₀), and with r = e^{−1/T},
//
//   h_k = K − c r^{k−k₀} for k ≥ k₀,   c = K q,   q = e^{−(k₀−L)/T} ∈ [r, 1),
//
// linear in (K, c). The sums it takes are geometric, or follow from those of
// k₀+1, so that one T costs O(N) for all dead times together.

#ifndef MLE_NONLINEAR_FOPDT_GRID_H_
#define MLE_NONLINEAR_FOPDT_GRID_H_

#include "Eigen/Core"

namespace mle {

struct FopdtParameters {
  double gain = 0.0;
  double time_constant = 1.0;  // In samples.
  double delay = 0.0;          // In samples.
};

struct FopdtBounds {
  double min_time_constant = 0.0;
  double max_time_constant = 0.0;
  double max_delay = 0.0;  // At most N − 3.
};

// The best dead time is found at every time constant of the grid; around the
// `num_minima` best of the local minima along it, T is then searched more
// closely. Returns the best of all.
FopdtParameters FindFopdtStart(
    const Eigen::Ref<const Eigen::VectorXd>& response,
    const FopdtBounds& bounds, int num_minima);

}  // namespace mle

#endif  // MLE_NONLINEAR_FOPDT_GRID_H_
