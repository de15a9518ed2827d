// The tables of mle_lifecycle.

#ifndef APPS_LIFECYCLE_TABLES_H_
#define APPS_LIFECYCLE_TABLES_H_

#include <string>
#include <vector>

#include "apps/lifecycle/summary.h"
#include "apps/report/table.h"

namespace mle::lifecycle {

// What a year costs under each policy, the cheapest first and the perfect model
// last, and how far it is from the cheapest.
report::Table ComparisonTable(const RateSummary& rate, std::size_t lives,
                              const std::string& currency);

// How often each policy acts, and how good its model is; in the order and with
// the names of --policies.
report::Table ActivityTable(const RateSummary& rate);

// Parts of the cost of a year.
report::Table CostTable(const RateSummary& rate, const std::string& currency);

// Policies by rates: the part of the avoidable cost that is saved, in percent.
report::Table SavingTable(const std::vector<RateSummary>& summaries);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_TABLES_H_
