// Advice about a result: the controller's tuning, where more records are
// needed, and which inputs alone a step test would have to move.

#ifndef APPS_CORRECT_ADVICE_H_
#define APPS_CORRECT_ADVICE_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/correct/result.h"
#include "control/mpc_options.h"

namespace mle::correct {

std::string_view NameOf(PairState state);

// The tuning that is running or, where it was not told, what published rules
// give for the initial model.
absl::StatusOr<control::MpcOptions> TuningInUse(const Result& result);

// The controller's horizons, weights and stability; empty where nothing was
// corrected.
Tuning AdviseTuning(const Result& result);

// Items, most urgent first. `result` is complete but for advice.
std::vector<std::string> Advise(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_ADVICE_H_
