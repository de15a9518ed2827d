// Stationary autoregressive moving-average noise, given by its poles p_i and
// zeros z_j:
//
//   Π_i (1 − p_i q⁻¹) ξ_k = Π_j (1 − z_j q⁻¹) e_k,
//
// q⁻¹ the delay of a sample, e_k white and Gaussian, of the variance that gives
// ξ the one asked for. Poles lie inside the unit circle; poles and zeros that
// are not real stand for themselves and their conjugates, and there are at most
// eight of each, so that no coefficient overflows. No poles and no
// zeros: white noise. Stationary from the first sample on.
//
// Computed in the form x_{k+1} = T x_k + R e_{k+1}, ξ_k = x_k[0], with x_0
// drawn from the stationary distribution (Harvey, Forecasting, Structural Time
// Series Models and the Kalman Filter, 1989, sec. 3.3).

#ifndef SIM_ARMA_NOISE_H_
#define SIM_ARMA_NOISE_H_

#include <complex>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/base/random.h"

namespace mle::sim {

struct ArmaOptions {
  std::vector<std::complex<double>> poles = {};  // |p| ≤ 1 − 1e-4
  std::vector<std::complex<double>> zeros = {};  // |z| ≤ 1000
  double variance = 0.0;                         // of ξ, ≥ 0

  absl::Status Validate() const;
};

// ξ_0 … ξ_{N−1}, for valid options. Twice the variance is the same path, √2
// times as large.
Eigen::RowVectorXd DrawArmaNoise(GaussianNoise& source,
                                 const ArmaOptions& options, int samples);

}  // namespace mle::sim

#endif  // SIM_ARMA_NOISE_H_
