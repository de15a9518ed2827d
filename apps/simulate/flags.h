// The flags of mle_simulate, turned into what is to be run. They are listed by
// `mle_simulate --help`.

#ifndef APPS_SIMULATE_FLAGS_H_
#define APPS_SIMULATE_FLAGS_H_

#include <string>

#include "absl/status/statusor.h"
#include "apps/simulate/simulation.h"

namespace mle::simulate {

// Reads the files and checks everything that can be checked before something is
// run; errors name the flag or the file.
absl::StatusOr<Simulation> SimulationFromFlags();

// Where the record goes.
std::string OutFromFlags();

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_FLAGS_H_
