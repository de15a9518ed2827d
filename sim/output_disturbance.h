// Unmeasured disturbances of the outputs.
//
//   d_k = ξ_k + w_k + s_k for each output, at sample k,
//   ξ_k = φ ξ_{k−1} + √(1−φ²) σ e_k,  φ = exp(−Δt/T)   coloured, stationary
//   w_k = w_{k−1} + √q e_k,           w_0 = 0          drift (random walk)
//   s_k: steps at the events of a Poisson process, of Gaussian size
//
// Each kind draws from a stream of its own that does not depend on any size:
// twice the variance is the same path, √2 times as large.

#ifndef SIM_OUTPUT_DISTURBANCE_H_
#define SIM_OUTPUT_DISTURBANCE_H_

#include <cstdint>

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle::sim {

// Vectors have a value for each output (p), or none: that kind is off.
struct OutputDisturbanceOptions {
  Eigen::VectorXd coloured_variance;     // σ² ≥ 0
  double coloured_time_constant = 10.0;  // T > 0
  Eigen::VectorXd drift_variance;        // q ≥ 0, of the increment per sample
  Eigen::VectorXd step_deviation;        // standard deviation of a step, ≥ 0
  double step_rate = 0.0;                // mean steps per unit of time, ≥ 0

  absl::Status Validate(int num_outputs) const;
};

// p × N: d_0 … d_{N−1}. For valid options.
Eigen::MatrixXd DrawOutputDisturbance(const OutputDisturbanceOptions& options,
                                      int num_outputs, double sample_time,
                                      int samples, std::uint64_t seed,
                                      std::uint64_t stream);

}  // namespace mle::sim

#endif  // SIM_OUTPUT_DISTURBANCE_H_
