// The disturbance of one output as a linear system, and its stationary Kalman
// filter.
//
// What a model leaves of an output, measured less simulated, is a random walk
// w, a coloured component a of first or second order and white measurement
// noise v (NoiseEstimate); or, in place of w and a, a walk behind a lag, as a
// load at an input is:
//
//   d_{k+1} = A d_k + ω_k,   z_k = C d_k + v_k,   Var ω = Q,  Var v = r,
//
// d = (w), (w, a) or (w, a, b); (w, x), x_{k+1} = φ x_k + (1 − φ) w_k. Every
// `samples`-th sample of it is a system of the same form, A^s and Σ_{i<s} A^i Q
// (A^i)ᵀ. Its best linear predictor is
//
//   d̂_{k+1} = A d̂_k + K (z_k − C d̂_k),   K = A P Cᵀ / F,   F = C P Cᵀ + r,
//   P = A P Aᵀ − A P Cᵀ C P Aᵀ / F + Q.
//
// P is found by doubling (Chu, Fan, Lin, Wang, International Journal of Control
// 77, 2004, 767–788), which squares the remaining error in each step.
//
//   const DisturbanceSystem system = SystemOf(noise, 1);
//   const StationaryFilter filter = SolveStationaryFilter(system);
//
// Internal to this project.

#ifndef MLE_FILTER_DISTURBANCE_SYSTEM_H_
#define MLE_FILTER_DISTURBANCE_SYSTEM_H_

#include <vector>

#include "Eigen/Core"
#include "mle/filter/output_filter.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// γ_0, γ_1, … of the coloured component, every `samples`-th sample, until they
// are below 1e-4 of the first, 1000 at most; empty without one.
std::vector<double> Autocovariances(const NoiseEstimate& noise, int samples);

// Σ = A Σ Aᵀ + Q of a component that decays.
StateMatrix StationaryCovariance(const StateMatrix& A, const StateMatrix& Q);

// The states as the walk makes them, and what decays: d = l w + (0, y),
//   y_{k+1} = B y_k + η_k,   Cov (ξ, η) = N,   C l = 1,
// where ξ are the increments of the walk.
struct LevelAndRest {
  StateVector level;  // l, n
  StateMatrix B;      // (n − 1) × (n − 1)
  StateMatrix N;      // n × n
};
LevelAndRest Separate(const DisturbanceSystem& system);

// r > 0, and the random walk's variance > 0.
StationaryFilter SolveStationaryFilter(const DisturbanceSystem& system);

}  // namespace mle

#endif  // MLE_FILTER_DISTURBANCE_SYSTEM_H_
