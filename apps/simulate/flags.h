// The flags of mle_simulate, as the settings of a run. `mle_simulate --help`
// lists them.

#ifndef APPS_SIMULATE_FLAGS_H_
#define APPS_SIMULATE_FLAGS_H_

#include <string>

#include "absl/status/statusor.h"
#include "apps/simulate/simulation.h"

namespace mle::simulate {

// Reads the files and checks everything that can be checked before something is
// run; errors name the flag or the file.
absl::StatusOr<Simulation> SimulationFromFlags();

// The file of the record.
std::string OutFromFlags();

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_FLAGS_H_
