// First-order coloured noise: white noise through a lag,
//
//   ξ_k = φ ξ_{k−1} + √(1−φ²) σ e_k,   φ = exp(−Δt/T),
//
// stationary from the first sample on, of variance σ² and with correlation
// exp(−|τ|/T).

#ifndef SIM_COLOURED_NOISE_H_
#define SIM_COLOURED_NOISE_H_

#include "Eigen/Core"
#include "mle/base/random.h"

namespace mle::sim {

// A row for each of the standard deviations ≥ 0; T > 0.
Eigen::MatrixXd DrawColouredNoise(GaussianNoise& source,
                                  const Eigen::VectorXd& deviations,
                                  double time_constant, double sample_time,
                                  int samples);

}  // namespace mle::sim

#endif  // SIM_COLOURED_NOISE_H_
