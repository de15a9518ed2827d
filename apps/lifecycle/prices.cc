#include "apps/lifecycle/prices.h"

namespace mle::lifecycle {

control::Cost CostOf(const ChangeRow& row, const control::Prices& prices,
                     double hours_per_unit) {
  control::Cost cost = control::CostOf(row.Total(), prices, hours_per_unit);
  if (row.tested()) {
    cost.test_hours = prices.test_hour * hours_per_unit * row.test.time;
    cost.engineering = prices.engineer_hour * prices.hours_per_test;
  } else if (row.outcome == Outcome::kUpdated ||
             row.outcome == Outcome::kRefused ||
             row.outcome == Outcome::kReverted) {
    cost.engineering = prices.engineer_hour * prices.hours_per_update;
  }
  return cost;
}

control::Cost CostOf(const Life& life, const control::Prices& prices,
                     double hours_per_unit) {
  control::Cost cost;
  for (const ChangeRow& row : life.rows) {
    cost.Add(CostOf(row, prices, hours_per_unit));
  }
  return cost;
}

}  // namespace mle::lifecycle
