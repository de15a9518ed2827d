// A non-linear plant: neutralisation of an acid by a base in a stirred tank,
// with a buffer. Nitric acid (stream 1), sodium bicarbonate (2) and sodium
// hydroxide with a little bicarbonate (3) leave together (4).
//
//   A ḣ    = q₁ + q₂ + q₃ − C_v √h
//   A h Ẇ_a = Σ q_i (W_ai − W_a),   A h Ẇ_b = Σ q_i (W_bi − W_b)
//   0      = W_a + 10^(pH − 14) − 10^(−pH)
//            + W_b (1 + 2·10^(pH − pK₂)) / (1 + 10^(pK₁ − pH) + 10^(pH − pK₂))
//   τ ẏ    = 7 + s (pH − 7) − y
//
// W_a: charge that does not react, [H⁺] − [OH⁻] − [HCO₃⁻] − 2 [CO₃²⁻]; W_b:
// all carbonate; y: what the electrode shows, with slope s = 1 when new.
//
// Inputs: the acid q₁ and the base q₃ [mL/s], which do not flow backwards.
// Outputs: the level h [cm], which the outflow under its own head makes stable,
// and y. Time in seconds. The buffer q₂ is not measured and holds pH near 6.35;
// with less of it, and away from there, pH answers several times as much.
//
// Equations, parameters and operating point (q = 16.6, 0.55, 15.6; h = 14.0, pH
// 7.0, W_a4 = −4.32e-4, W_b4 = 5.28e-4 mol/L): Henson and Seborg, Adaptive
// nonlinear control of a pH neutralization process, IEEE Transactions on
// Control Systems Technology 2(3), 1994, 169–182. The publication's base flow
// of 15.6 is rounded: 15.55, the default, gives W_a4 = −4.32e-4 and pH 7.00,
// 15.6 gives −4.36e-4 and 7.03. In the publication the acid is a disturbance
// and the level is of no interest; here it is the second input, so that both
// outputs are controlled. The electrode is not of the publication.

#ifndef SIM_PH_NEUTRALISATION_H_
#define SIM_PH_NEUTRALISATION_H_

#include <vector>

#include "absl/status/statusor.h"
#include "sim/continuous_plant.h"
#include "sim/plant_at_rest.h"
#include "sim/schedule.h"

namespace mle::sim {

struct PhNeutralisationOptions {
  double acid = 16.6;           // q₁ > 0 [mL/s]
  double base = 15.55;          // q₃ > 0 [mL/s]
  double buffer = 0.55;         // q₂ > 0 [mL/s]
  double electrode_lag = 15.0;  // τ > 0 [s]
  // Pumps that wear, a buffer stream that changes, an outlet valve that fouls,
  // an electrode that ages: factors of q₁, q₃, q₂, C_v, s and τ at the time of
  // the plant.
  Schedule acid_factor = Schedule(1.0);  // > 0
  Schedule base_factor = Schedule(1.0);
  Schedule buffer_factor = Schedule(1.0);
  Schedule outlet_factor = Schedule(1.0);
  Schedule slope_factor = Schedule(1.0);
  Schedule lag_factor = Schedule(1.0);
};

// By the names that files of ageing have for them: `acid`, `base`, `buffer`,
// `outlet`, `electrode_slope`, `electrode_lag`.
std::vector<AgeingFactor> AgeingFactors(PhNeutralisationOptions& options);

// The pH at which the charges are balanced, to rounding; W_a and W_b ≥ 0 in
// mmol/L.
double PhOfInvariants(double wa, double wb);

// At its steady state for the given inputs, at time `start_time`; inputs and
// outputs are deviations from it. States: h, W_a, W_b [mmol/L], y.
// InvalidArgument for an option out of range.
absl::StatusOr<ContinuousSystem> MakePhNeutralisation(
    PhNeutralisationOptions options, double start_time = 0.0);

}  // namespace mle::sim

#endif  // SIM_PH_NEUTRALISATION_H_
