// The options of mle_simulate for what a plant has to bear.

#ifndef APPS_SIMULATE_CONDITION_OPTIONS_H_
#define APPS_SIMULATE_CONDITION_OPTIONS_H_

#include <vector>

#include "apps/common/option_table.h"
#include "sim/plant_conditions.h"

namespace mle::simulate {

std::vector<Option> OptionsOf(sim::OutputDisturbanceOptions& options);
// But for their steps, which name inputs.
std::vector<Option> OptionsOf(sim::InputDisturbanceOptions& options);
std::vector<Option> OptionsOf(sim::ValveLimits& limits);
std::vector<Option> OptionsOf(sim::MeasurementFaultOptions& options);

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_CONDITION_OPTIONS_H_
