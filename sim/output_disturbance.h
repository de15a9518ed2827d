// Unmeasured disturbances of the outputs.
//
//   d_k = ξ_k + w_k + s_k + a_k + p_k for each output, at sample k,
//   ξ_k = φ ξ_{k−1} + √(1−φ²) σ e_k,  φ = exp(−Δt/T)   coloured, stationary
//   w_k = w_{k−1} + √q e_k,           w_0 = 0          drift (random walk)
//   s_k: steps at the events of a Poisson process, of Gaussian size, and at
//        given times
//   a_k: stationary noise of given poles and zeros (arma_noise.h)
//   p_k = A sin(2π kΔt/P + φ)         periodic
//
// Each kind draws from a stream of its own that does not depend on any size:
// twice the variance is the same path, √2 times as large.

#ifndef SIM_OUTPUT_DISTURBANCE_H_
#define SIM_OUTPUT_DISTURBANCE_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "sim/arma_noise.h"
#include "sim/signal_step.h"

namespace mle::sim {

struct ArmaDisturbance {
  int output = 0;
  ArmaOptions noise;
};

struct SineDisturbance {
  int output = 0;
  double amplitude = 0.0;            // A ≥ 0
  double period = 1.0;               // P > 0
  std::optional<double> phase = {};  // φ in radians; none: drawn
};

struct OutputStep {
  int output = 0;
  SignalStep step;
};

// Vectors have a value for each output (p), or none: that kind is off.
struct OutputDisturbanceOptions {
  Eigen::VectorXd coloured_variance;     // σ² ≥ 0
  double coloured_time_constant = 10.0;  // T > 0
  Eigen::VectorXd drift_variance;        // q ≥ 0, of the increment per sample
  Eigen::VectorXd step_deviation;        // standard deviation of a step, ≥ 0
  double step_rate = 0.0;                // mean steps per unit of time, ≥ 0
  std::vector<ArmaDisturbance> arma;
  std::vector<SineDisturbance> sines;
  std::vector<OutputStep> steps;

  absl::Status Validate(int num_outputs) const;
};

// p × N: d_0 … d_{N−1}. For valid options.
Eigen::MatrixXd DrawOutputDisturbance(const OutputDisturbanceOptions& options,
                                      int num_outputs, double sample_time,
                                      int samples, std::uint64_t seed,
                                      std::uint64_t stream);

}  // namespace mle::sim

#endif  // SIM_OUTPUT_DISTURBANCE_H_
