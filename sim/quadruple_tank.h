// A non-linear plant: the quadruple-tank process. Two pumps fill four tanks,
// of which the upper ones (3, 4) empty into the lower ones (1, 2); a valve
// splits what each pump lifts between a lower tank and the upper tank of the
// other side.
//
//   A₁ ḣ₁ = −a₁ √(2 g h₁) + a₃ √(2 g h₃) + γ₁ k₁ v₁
//   A₂ ḣ₂ = −a₂ √(2 g h₂) + a₄ √(2 g h₄) + γ₂ k₂ v₂
//   A₃ ḣ₃ = −a₃ √(2 g h₃) + (1 − γ₂) k₂ v₂
//   A₄ ḣ₄ = −a₄ √(2 g h₄) + (1 − γ₁) k₁ v₁
//
// Inputs: the voltages v₁ and v₂ of the pumps [V], which do not pump backwards.
// Outputs: the levels h₁ and h₂ of the lower tanks [cm]; the publication has
// them in volts of a sensor with 0.50 V/cm. Time in seconds. The zeros of the
// linearised plant are both in the left half-plane for γ₁ + γ₂ > 1, one is in
// the right one for γ₁ + γ₂ < 1; time constants and gains grow as the square
// roots of the levels.
//
// Equations, parameters and the operating points P− (the defaults: h = 12.4,
// 12.7, 1.8, 1.4 cm) and P+ (v = 3.15, 3.15, k = 3.14, 3.29, γ = 0.43, 0.34; h
// = 12.6, 13.0, 4.8, 4.9): Johansson, The quadruple-tank process: a
// multivariable laboratory process with an adjustable zero, IEEE Transactions
// on Control Systems Technology 8(3), 2000, 456–465.

#ifndef SIM_QUADRUPLE_TANK_H_
#define SIM_QUADRUPLE_TANK_H_

#include <vector>

#include "absl/status/statusor.h"
#include "sim/continuous_plant.h"
#include "sim/plant_at_rest.h"
#include "sim/schedule.h"

namespace mle::sim {

struct QuadrupleTankOptions {
  double voltage1 = 3.00;  // v > 0 [V]
  double voltage2 = 3.00;
  double pump1 = 3.33;  // k > 0 [cm³/(V s)]
  double pump2 = 3.35;
  double split1 = 0.70;  // 0 < γ < 1
  double split2 = 0.60;
  // Pumps that wear, splits that move (γ stays in (0, 1)), outlets that foul:
  // factors of k, γ and a at the time of the plant.
  Schedule pump1_factor = Schedule(1.0);  // > 0
  Schedule pump2_factor = Schedule(1.0);
  Schedule split1_factor = Schedule(1.0);
  Schedule split2_factor = Schedule(1.0);
  Schedule outlet1_factor = Schedule(1.0);
  Schedule outlet2_factor = Schedule(1.0);
  Schedule outlet3_factor = Schedule(1.0);
  Schedule outlet4_factor = Schedule(1.0);
};

// By the names that files of ageing have for them: `pump1` and so on.
std::vector<AgeingFactor> AgeingFactors(QuadrupleTankOptions& options);

// At its steady state for the given inputs, at time `start_time`; inputs and
// outputs are deviations from it. States: h₁ to h₄. InvalidArgument for an
// option out of range.
absl::StatusOr<ContinuousSystem> MakeQuadrupleTank(QuadrupleTankOptions options,
                                                   double start_time = 0.0);

}  // namespace mle::sim

#endif  // SIM_QUADRUPLE_TANK_H_
