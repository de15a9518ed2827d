// The options of a correction from records: the same in every command that
// makes one.

#ifndef APPS_COMMON_CORRECT_OPTIONS_H_
#define APPS_COMMON_CORRECT_OPTIONS_H_

#include <vector>

#include "apps/common/option_table.h"
#include "mle/maintain/correct.h"

namespace mle {

// Estimator, test of no change, conversion to an ARX model, ΔR.
std::vector<Option> OptionsOf(EstimationOptions& options);

std::vector<Option> OptionsOf(HoldOutOptions& options);

std::vector<Option> OptionsOf(DecisionOptions& options);

}  // namespace mle

#endif  // APPS_COMMON_CORRECT_OPTIONS_H_
