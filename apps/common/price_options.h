// The options of prices: the same in every command.

#ifndef APPS_COMMON_PRICE_OPTIONS_H_
#define APPS_COMMON_PRICE_OPTIONS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "control/operating_cost.h"

namespace mle {

std::vector<Option> OptionsOf(control::Prices& prices);

// The name of the money that prices are in, which is shown with every amount;
// longer ones have no place in tables and on axes.
absl::Status CheckCurrency(const std::string& name);

}  // namespace mle

#endif  // APPS_COMMON_PRICE_OPTIONS_H_
