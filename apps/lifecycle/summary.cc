#include "apps/lifecycle/summary.h"

#include <cmath>

#include "mle/base/double_limits.h"
#include "mle/nonlinear/distributions.h"

namespace mle::lifecycle {
namespace {

constexpr double kLevel = 0.05;  // of the intervals, two-sided

// Mean of the values that are known; NaN if none is.
class KnownMean {
 public:
  void Add(double value) {
    if (!std::isfinite(value)) return;
    sum_ += value;
    ++count_;
  }
  double value() const { return count_ > 0 ? sum_ / count_ : kNaN; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

double CostPerYear(const Life& life, const Valuation& valuation) {
  if (!life.ended.empty()) return kNaN;
  return CostOf(life, valuation.prices, valuation.hours_per_unit).total() /
         valuation.years;
}

void CountEvents(const Life& life, double weight, double hours_per_unit,
                 PolicySummary& summary) {
  for (const ChangeRow& row : life.rows) {
    if (row.tested()) {
      summary.tests += weight;
      summary.test_hours += weight * row.test.time * hours_per_unit;
    }
    if (row.outcome == Outcome::kUpdated) summary.updates += weight;
    if (row.outcome == Outcome::kRefused) summary.refusals += weight;
    if (row.outcome == Outcome::kReverted) summary.reverted += weight;
    if (row.outcome == Outcome::kNoChange) summary.unchanged += weight;
  }
}

// `lives` of one policy, by seed.
PolicySummary SummarisePolicy(const Policy& policy,
                              const std::vector<const Life*>& lives,
                              const Valuation& valuation) {
  PolicySummary summary;
  summary.policy = policy;
  std::vector<double> costs;
  KnownMean distance, gain_error, delay_error;
  const double weight = 1.0 / static_cast<double>(lives.size());
  for (const Life* life : lives) {
    costs.push_back(CostPerYear(*life, valuation));
    if (!life->ended.empty()) ++summary.ran_away;
    const control::Cost cost =
        CostOf(*life, valuation.prices, valuation.hours_per_unit);
    const double share = weight / valuation.years;
    summary.parts.Add({share * cost.product, share * cost.violation,
                       share * cost.movement, share * cost.test_hours,
                       share * cost.engineering});
    CountEvents(*life, weight, valuation.hours_per_unit, summary);
    for (const ChangeRow& row : life->rows) {
      distance.Add(row.error.distance);
      gain_error.Add(row.error.gain);
      delay_error.Add(row.error.delay);
    }
  }
  summary.cost = MeanWithInterval(costs);
  summary.distance = distance.value();
  summary.gain_error = gain_error.value();
  summary.delay_error = delay_error.value();
  return summary;
}

// Cost of policy a less that of b, seed by seed; NaN where one is not run.
MeanOfSeeds Difference(const std::vector<std::vector<Life>>& lives,
                       std::size_t a, std::size_t b,
                       const Valuation& valuation) {
  std::vector<double> differences;
  for (const std::vector<Life>& of_seed : lives) {
    if (a >= of_seed.size() || b >= of_seed.size()) return {kNaN, kNaN};
    differences.push_back(CostPerYear(of_seed[a], valuation) -
                          CostPerYear(of_seed[b], valuation));
  }
  return MeanWithInterval(differences);
}

void AddDifferences(const Campaign& campaign,
                    const std::vector<std::vector<Life>>& lives,
                    const Valuation& valuation, RateSummary& rate) {
  const std::size_t never = PlaceOf(Policy::Kind::kNever, campaign.policies);
  const std::size_t perfect =
      PlaceOf(Policy::Kind::kPerfect, campaign.policies);
  const double possible = Difference(lives, never, perfect, valuation).mean;
  const PolicySummary* best = rate.Cheapest();
  const std::size_t cheapest =
      best == nullptr ? rate.policies.size() : best - rate.policies.data();
  for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
    PolicySummary& policy = rate.policies[p];
    policy.saving = Difference(lives, never, p, valuation);
    policy.excess = Difference(lives, p, perfect, valuation);
    policy.over_cheapest = Difference(lives, p, cheapest, valuation);
    policy.share_saved = possible > 0.0 ? policy.saving.mean / possible : kNaN;
  }
}

BreakEven FindBreakEven(const RateSummary& rate, const Valuation& valuation) {
  BreakEven found;
  found.price = kNaN;
  const PolicySummary* correction = nullptr;
  for (const PolicySummary& policy : rate.policies) {
    if (policy.policy.kind != Policy::Kind::kCorrection) continue;
    if (correction == nullptr || policy.cost.mean < correction->cost.mean) {
      correction = &policy;
    }
  }
  if (correction == nullptr || std::isnan(correction->cost.mean)) return found;
  for (const PolicySummary& policy : rate.policies) {
    if (!policy.policy.tests() || !(policy.test_hours > 0.0)) continue;
    const double hours = policy.test_hours / valuation.years;
    const double without =
        policy.cost.mean - valuation.prices.test_hour * hours;
    const double price = (correction->cost.mean - without) / hours;
    if (std::isnan(found.price) || price > found.price) {
      found = {policy.policy.name, correction->policy.name, price};
    }
  }
  return found;
}

}  // namespace

MeanOfSeeds MeanWithInterval(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  MeanOfSeeds result;
  for (const double value : values) result.mean += value / n;
  if (values.size() < 2) {
    result.half_width = kNaN;
    return result;
  }
  double squares = 0.0;
  for (const double value : values) {
    squares += (value - result.mean) * (value - result.mean);
  }
  result.half_width = StudentTwoSidedQuantile(kLevel, n - 1.0) *
                      std::sqrt(squares / (n - 1.0) / n);
  return result;
}

bool ToldApart(const MeanOfSeeds& difference) {
  return std::isfinite(difference.half_width) &&
         std::abs(difference.mean) > difference.half_width;
}

const PolicySummary* RateSummary::Find(Policy::Kind kind) const {
  for (const PolicySummary& policy : policies) {
    if (policy.policy.kind == kind) return &policy;
  }
  return nullptr;
}

const PolicySummary* RateSummary::Cheapest() const {
  const PolicySummary* best = nullptr;
  for (const PolicySummary& policy : policies) {
    if (policy.policy.kind == Policy::Kind::kPerfect) continue;
    if (std::isnan(policy.cost.mean)) continue;
    if (best == nullptr || policy.cost.mean < best->cost.mean) best = &policy;
  }
  return best;
}

std::vector<RateSummary> Summarise(const Campaign& campaign, const Lives& lives,
                                   const Valuation& valuation) {
  std::vector<RateSummary> summaries;
  const std::size_t seeds = campaign.seeds.size();
  for (std::size_t r = 0; r < campaign.rates.size(); ++r) {
    RateSummary& rate = summaries.emplace_back();
    rate.rate = campaign.rates[r];
    for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
      std::vector<const Life*> of_policy;
      for (std::size_t s = 0; s < seeds; ++s) {
        of_policy.push_back(&lives[r][s][p]);
      }
      rate.policies.push_back(
          SummarisePolicy(campaign.policies[p], of_policy, valuation));
    }
    AddDifferences(campaign, lives[r], valuation, rate);
    rate.break_even = FindBreakEven(rate, valuation);
  }
  return summaries;
}

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
