// Sampled step responses of a p × m process, and measures computed from them.
//
// φ_k^{ij} is the response of output i to a unit step of input j at t = 0,
// sampled at kΔt, k = 0 … N. That of an element that integrates ends in a ramp.

#ifndef MLE_MODEL_STEP_RESPONSE_H_
#define MLE_MODEL_STEP_RESPONSE_H_

#include "Eigen/Core"

namespace mle {

struct StepResponse {
  double sample_time = 0.0;  // Δt
  int num_outputs = 0;       // p
  int num_inputs = 0;        // m
  // (N+1) × pm; column i·m + j holds φ^{ij}.
  Eigen::MatrixXd values;
  // p × m: orders of integration, as far as they are known; empty: of elements
  // that settle.
  Eigen::MatrixXi integration = {};

  StepResponse() = default;
  StepResponse(double sample_time, int num_outputs, int num_inputs,
               int samples);

  int samples() const { return static_cast<int>(values.rows()); }
  auto element(int output, int input) const {
    return values.col(output * num_inputs + input);
  }
  auto element(int output, int input) {
    return values.col(output * num_inputs + input);
  }
  bool IsIntegrating(int output, int input) const {
    return integration.size() > 0 && integration(output, input) > 0;
  }
};

// E(M, M̂) = Σ_ij Σ_k (φ_k^{ij}(M) − φ_k^{ij}(M̂))². Both of the same shape.
double SquaredDistance(const StepResponse& a, const StepResponse& b);

// p × m: the last sample of every response, the static gain of a settled one.
Eigen::MatrixXd FinalValues(const StepResponse& response);

// Impulse responses, in output per (input × time): column by column
// (φ_k − φ_{k−1}) / Δt at k ≥ 1, zero at k = 0. (N+1) × pm.
Eigen::MatrixXd ImpulseResponses(const StepResponse& response);

// p × m: the time kΔt at which each impulse response is largest in magnitude.
// The response of a first-order element with dead time L is steepest in the
// first whole sample after L, so that this reads L rounded up to a multiple of
// Δt, plus Δt: the end of that sample.
Eigen::MatrixXd ImpulsePeakTimes(const StepResponse& response);

}  // namespace mle

#endif  // MLE_MODEL_STEP_RESPONSE_H_
