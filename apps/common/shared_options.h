// The options of structs of the library that several commands have: the same in
// every command.

#ifndef APPS_COMMON_SHARED_OPTIONS_H_
#define APPS_COMMON_SHARED_OPTIONS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "control/mpc_options.h"
#include "control/operating_cost.h"
#include "mle/maintain/correct.h"
#include "mle/model/process_model.h"

namespace mle {

// Of a predictive controller: period, horizons, weights and observer.
std::vector<Option> OptionsOf(control::MpcOptions& mpc);

// Limits of its inputs, moves and outputs.
std::vector<Option> OptionsOf(control::MpcLimits& limits);

// The options' own check, for this model. The message names the options.
absl::Status CheckController(const control::MpcOptions& mpc,
                             const ProcessModel& model);

std::vector<Option> OptionsOf(control::Prices& prices);

// The name of the money that prices are in, which is shown with every amount;
// longer ones have no place in tables and on axes.
absl::Status CheckCurrency(const std::string& name);

// Of a correction from records: estimator, test of no change, conversion to an
// ARX model, ΔR.
std::vector<Option> OptionsOf(EstimationOptions& options);
std::vector<Option> OptionsOf(HoldOutOptions& options);
std::vector<Option> OptionsOf(DecisionOptions& options);

}  // namespace mle

#endif  // APPS_COMMON_SHARED_OPTIONS_H_
