// An upper bound of the gain of a finite impulse response over all frequencies,
//
//   max_ω |P(ω)|,   P(ω) = Σ_{l=0..N−1} h_l e^{−jωl}.
//
// |P|² is a trigonometric polynomial of degree n = N − 1. Within π/M of its
// maximum it stays above cos(nπ/M) of it (M. Riesz, Jahresber. DMV 23, 1914),
// so that of its values at M ≥ 8 N equally spaced frequencies, which a fast
// Fourier transform gives,
//
//   max_ω |P(ω)|² ≤ max_k |P(2πk/M)|² / cos(nπ/M),
//
// at most 4 % above the maximum of |P|.

#ifndef MLE_MODEL_LARGEST_GAIN_H_
#define MLE_MODEL_LARGEST_GAIN_H_

#include "Eigen/Core"

namespace mle {

// The bound for `impulse` (N); 0 for an empty one. Cost: 40 N log₂ 8N
// operations or so.
double LargestGainBound(const Eigen::VectorXd& impulse);

}  // namespace mle

#endif  // MLE_MODEL_LARGEST_GAIN_H_
