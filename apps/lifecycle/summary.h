// Mean costs of lives over the seeds, with intervals.
//
// All policies have the same noise, so that differences between them have
// smaller intervals than their costs: savings are differences by seed.
// Intervals are of 95 %, by Student's t over the seeds; NaN with one seed.

#ifndef APPS_LIFECYCLE_SUMMARY_H_
#define APPS_LIFECYCLE_SUMMARY_H_

#include <string>
#include <vector>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/life.h"
#include "apps/lifecycle/policy.h"
#include "control/operating_cost.h"

namespace mle::lifecycle {

struct MeanOfSeeds {
  double mean = 0.0;
  double half_width = 0.0;  // of the interval
};

MeanOfSeeds MeanWithInterval(const std::vector<double>& values);

// Whether the interval of a difference is known and does not hold zero.
bool ToldApart(const MeanOfSeeds& difference);

struct PolicySummary {
  Policy policy;
  // A year's, in money; NaN where the loop diverged in a seed.
  MeanOfSeeds cost;
  control::Cost parts;  // mean of each part
  MeanOfSeeds saving;   // never less this policy; NaN without never
  MeanOfSeeds excess;   // this policy less perfect; NaN without perfect
  // This policy less the cheapest one (RateSummary::Cheapest); NaN where the
  // loop diverged in a life of one of them.
  MeanOfSeeds over_cheapest;
  // Share of what never costs more than perfect that this policy saves;
  // NaN without both, or where they do not differ.
  double share_saved = 0.0;
  // Means over lives.
  double updates = 0.0;
  double refusals = 0.0;
  double reverted = 0.0;
  double unchanged = 0.0;  // corrections that found no change
  double tests = 0.0;
  double test_hours = 0.0;  // of a whole life
  double distance = 0.0;    // E, mean over the changes
  double gain_error = 0.0;  // of those that are known
  double delay_error = 0.0;
  int ran_away = 0;  // lives
};

// The price of an hour of step test at which the best policy of tests costs as
// much as the best one of corrections: below it, tests are cheaper. At a given
// price p a policy's cost is a + b p.
struct BreakEven {
  std::string test;  // the policies compared; empty where there are none
  std::string correction;
  double price = 0.0;  // below zero: never
};

struct RateSummary {
  double rate = 1.0;
  std::vector<PolicySummary> policies;
  BreakEven break_even;

  // The one of that kind; null if there is none.
  const PolicySummary* Find(Policy::Kind kind) const;
  // The cheapest but perfect; null if every loop ran away.
  const PolicySummary* Cheapest() const;
};

struct Valuation {
  control::Prices prices;
  double hours_per_unit = 1.0;
  double years = 1.0;
  std::string currency = {};  // of the prices, as it is shown; may be empty
};

std::vector<RateSummary> Summarise(const Campaign& campaign, const Lives& lives,
                                   const Valuation& valuation);

// The cost of a life at given prices (control/operating_cost.h).

// Product made during a step test counts with the rest. Corrections that found
// no change cost no engineer.
control::Cost CostOf(const ChangeRow& row, const control::Prices& prices,
                     double hours_per_unit);
control::Cost CostOf(const Life& life, const control::Prices& prices,
                     double hours_per_unit);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_SUMMARY_H_
