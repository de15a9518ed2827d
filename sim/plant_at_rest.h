// Non-linear plants of the literature: what they have in common, so that each
// is its equations, its operating point and what ages in it.
//
//   ẋ = f(t, x, w),   y_i = x_{o_i},   f(t₀, x⁰, u⁰) = 0,
//
// with x: n states, w: the inputs as they arrive, u⁰: the inputs at which the
// plant rests at the time t₀. Examples: van_de_vusse.h, quadruple_tank.h,
// ph_neutralisation.h.

#ifndef SIM_PLANT_AT_REST_H_
#define SIM_PLANT_AT_REST_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "sim/ageing.h"
#include "sim/continuous_plant.h"

namespace mle::sim {

// Positive all the time; InvalidArgument names the factor.
absl::Status CheckFactors(const std::vector<AgeingFactor>& factors);

struct PlantEquations {
  SystemFunction derivative;   // f
  std::vector<int> outputs;    // o: the states that are outputs
  Eigen::VectorXd inputs;      // u⁰ (m)
  Eigen::VectorXd guess;       // of x⁰ (n)
  std::vector<double> delays;  // dead time of every input; empty: none
};

// The plant at x⁰, at t₀ = `start_time`; its inputs and outputs are deviations
// from there. Its largest integration step is 0.02 of the fastest time constant
// there, as rates may grow by an order of magnitude away from it. The times of
// `factors` are breaks. FailedPrecondition where no steady state is found.
absl::StatusOr<ContinuousSystem> MakePlantAtRest(
    PlantEquations equations, const std::vector<AgeingFactor>& factors,
    double start_time);

}  // namespace mle::sim

#endif  // SIM_PLANT_AT_REST_H_
