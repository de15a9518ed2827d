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

#ifndef MLE_FILTER_DISTURBANCE_SYSTEM_H_
#define MLE_FILTER_DISTURBANCE_SYSTEM_H_

#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// Of up to three states, which take no memory from the heap.
using StateMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;
using StateRow =
    Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 3>;

struct DisturbanceSystem {
  // n × n. The first state is the walk, A(0, :) = (1, 0, …).
  StateMatrix A;
  StateRow C;                   // n
  StateMatrix Q;                // n × n
  double noise_variance = 0.0;  // r

  Eigen::Index order() const { return A.rows(); }
};

// Every `samples`-th sample, ≥ 1. With `walk_lag` > 0, in samples, the walk
// acts behind a lag of this time constant, and there is no coloured component.
// Sinusoids and steps of the estimate are left out.
DisturbanceSystem SystemOf(const NoiseEstimate& noise, int samples,
                           double walk_lag = 0.0);

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

struct StationaryFilter {
  StateVector gain;                  // K, n
  StateMatrix covariance;            // P, n × n, of d̂ before its sample
  double innovation_variance = 0.0;  // F
  // The certificate: what the equation of P leaves, relative to the largest
  // entry of P.
  double residual = 0.0;
};

// r > 0, and the random walk's variance > 0.
StationaryFilter SolveStationaryFilter(const DisturbanceSystem& system);

}  // namespace mle

#endif  // MLE_FILTER_DISTURBANCE_SYSTEM_H_
