// A non-linear plant: the benchmark stirred tank reactor with the reactions of
// Van de Vusse, A → B → C and 2 A → D.
//
//   ċ_A = F (c_A0 − c_A) − k₁ c_A − k₃ c_A²
//   ċ_B = −F c_B + k₁ c_A − k₂ c_B
//   ϑ̇  = F (ϑ₀ − ϑ) − (k₁ c_A ΔH_AB + k₂ c_B ΔH_BC + k₃ c_A² ΔH_AD) / (ρ C_p)
//        + k_w A_R / (ρ C_p V_R) (ϑ_K − ϑ)
//   ϑ̇_K = (Q + k_w A_R (ϑ − ϑ_K)) / (m_K C_pK)
//   k_i = k_i0 exp(E_i / (ϑ + 273.15))
//
// Inputs: the feed per volume F [1/h] and the heat Q [kJ/h] put into the jacket
// (negative: cooling). Outputs: the concentration c_B [mol/L] of the product
// and the temperature ϑ [°C]. Time in hours. More feed first dilutes B and then
// makes more or less of it: its static gain turns its sign near F = 14.5, where
// c_B is largest, so that no linear model holds everywhere.
//
// Parameters and operating point (c_A = 2.14, c_B = 1.09, ϑ = 114.2, ϑ_K =
// 112.9 at F = 14.19, Q = −1113.5): Chen, Kremling and Allgöwer, Nonlinear
// predictive control of a benchmark CSTR, European Control Conference, 1995,
// p. 3247; Klatt and Engell, Gain-scheduling trajectory control of a continuous
// stirred tank reactor, Computers and Chemical Engineering 22, 1998, p. 491.

#ifndef SIM_VAN_DE_VUSSE_H_
#define SIM_VAN_DE_VUSSE_H_

#include <vector>

#include "absl/status/statusor.h"
#include "sim/continuous_plant.h"
#include "sim/plant_at_rest.h"
#include "sim/schedule.h"

namespace mle::sim {

struct VanDeVusseOptions {
  double feed = 14.19;               // F > 0 [1/h]
  double heat = -1113.5;             // Q [kJ/h]
  double feed_concentration = 5.10;  // c_A0 > 0 [mol/L]
  double feed_temperature = 104.9;   // ϑ₀ [°C]
  // Dead time of what the feed and the heat do, for longer lines [h].
  double feed_delay = 0.0;
  double heat_delay = 0.0;
  // Catalyst that dies, a jacket that fouls: factors of all rate constants and
  // of k_w, at the time of the plant.
  Schedule activity = Schedule(1.0);       // > 0
  Schedule heat_transfer = Schedule(1.0);  // > 0
};

// By the names that files of ageing have for them.
std::vector<AgeingFactor> AgeingFactors(VanDeVusseOptions& options);

// At its steady state for the given inputs, at time `start_time`; inputs and
// outputs are deviations from it. States: c_A, c_B, ϑ, ϑ_K. InvalidArgument for
// an option out of range, FailedPrecondition where no steady state is found.
absl::StatusOr<ContinuousSystem> MakeVanDeVusseReactor(
    VanDeVusseOptions options, double start_time = 0.0);

}  // namespace mle::sim

#endif  // SIM_VAN_DE_VUSSE_H_
