// What to do with the result: the controller's tuning, where more records are
// needed, and which inputs alone a step test would have to move.

#ifndef APPS_CORRECT_ADVICE_H_
#define APPS_CORRECT_ADVICE_H_

#include <string>
#include <string_view>
#include <vector>

#include "apps/correct/result.h"

namespace mle::correct {

std::string_view NameOf(PairState state);

// The controller's horizons, weights and stability; empty where nothing was
// corrected.
Tuning AdviseTuning(const Result& result);

// Items, most urgent first. `result` is complete but for advice.
std::vector<std::string> Advise(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_ADVICE_H_
