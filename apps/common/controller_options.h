// The options of a predictive controller: the same in every command.

#ifndef APPS_COMMON_CONTROLLER_OPTIONS_H_
#define APPS_COMMON_CONTROLLER_OPTIONS_H_

#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "control/mpc_options.h"
#include "mle/model/process_model.h"

namespace mle {

// Period, horizons, weights and observer.
std::vector<Option> OptionsOf(control::MpcOptions& mpc);

// Limits of inputs, moves and outputs.
std::vector<Option> OptionsOf(control::MpcLimits& limits);

// The options' own check, for this model. The message names the options.
absl::Status CheckController(const control::MpcOptions& mpc,
                             const ProcessModel& model);

}  // namespace mle

#endif  // APPS_COMMON_CONTROLLER_OPTIONS_H_
