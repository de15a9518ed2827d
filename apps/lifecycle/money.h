// Amounts of money as they are shown: whole numbers from 100 on, three digits
// below.

#ifndef APPS_LIFECYCLE_MONEY_H_
#define APPS_LIFECYCLE_MONEY_H_

#include <string>

#include "apps/lifecycle/summary.h"

namespace mle::lifecycle {

// "8,610 ± 1,107"; the mean alone without an interval.
std::string Money(const MeanOfSeeds& amount);
// The same with the currency behind it, if it has a name: "8,610 ± 1,107 EUR".
std::string Money(const MeanOfSeeds& amount, const std::string& currency);

// ", EUR" for captions and axes; empty without a name.
std::string InCurrency(const std::string& currency);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_MONEY_H_
