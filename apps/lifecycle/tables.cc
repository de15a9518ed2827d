#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/report.h"
#include "apps/report/text.h"

namespace mle::lifecycle {
namespace {

using report::Align;
using report::FormatFixed;
using report::FormatSignificant;
using report::Table;

// Levels of the ground of a cell.
constexpr int kCheapestLevel = 3;
constexpr int kAsGoodLevel = 1;
constexpr int kDarkest = 4;

std::string Percent(double share) {
  return std::isfinite(share) ? FormatFixed(100.0 * share, 0) + " %" : "–";
}

std::string RateTitle(const RateSummary& rate) {
  return absl::StrCat("Ageing rate ", rate.rate);
}

bool IsPerfect(const PolicySummary& policy) {
  return policy.policy.kind == Policy::Kind::kPerfect;
}

// The cheapest first; then those whose loop diverged; then the reference.
std::vector<const PolicySummary*> ByCost(const RateSummary& rate) {
  std::vector<const PolicySummary*> sorted;
  for (const PolicySummary& policy : rate.policies) sorted.push_back(&policy);
  const auto place = [](const PolicySummary& policy) {
    return IsPerfect(policy) ? 2 : std::isnan(policy.cost.mean) ? 1 : 0;
  };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const auto* a, const auto* b) {
                     if (place(*a) != place(*b)) return place(*a) < place(*b);
                     return place(*a) == 0 && a->cost.mean < b->cost.mean;
                   });
  return sorted;
}

// How a policy compares with the cheapest one, and the level of that cell.
struct Comparison {
  std::string words;
  int level = 0;
};

Comparison Compare(const PolicySummary& policy, const PolicySummary* cheapest,
                   std::size_t lives) {
  if (policy.ran_away > 0) {
    return {absl::StrCat("diverged in ", policy.ran_away, " of ", lives)};
  }
  if (IsPerfect(policy)) return {"the reference"};
  if (&policy == cheapest) return {"cheapest", kCheapestLevel};
  if (!ToldApart(policy.over_cheapest)) {
    return {"cannot be told apart", kAsGoodLevel};
  }
  return {"costs more"};
}

// Beyond what chance does.
bool Pays(const MeanOfSeeds& saving) {
  return saving.mean > 0.0 && !(saving.half_width >= saving.mean);
}

double LargestSaving(const RateSummary& rate) {
  double largest = 0.0;
  for (const PolicySummary& policy : rate.policies) {
    if (Pays(policy.saving)) largest = std::max(largest, policy.saving.mean);
  }
  return largest;
}

std::vector<const RateSummary*> ByRate(
    const std::vector<RateSummary>& summaries) {
  std::vector<const RateSummary*> sorted;
  for (const RateSummary& rate : summaries) sorted.push_back(&rate);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto* a, const auto* b) { return a->rate < b->rate; });
  return sorted;
}

}  // namespace

Table ComparisonTable(const RateSummary& rate, std::size_t lives,
                      const std::string& currency) {
  Table table{.caption = absl::StrCat(
                  "What a year costs under each policy, ageing rate ",
                  rate.rate, InCurrency(currency)),
              .columns = {{"policy", Align::kLeft},
                          {"cost a year"},
                          {"more than the cheapest"},
                          {"that is", Align::kLeft},
                          {"saved against never"},
                          {"of what is possible"}},
              .stacked = true};
  const PolicySummary* cheapest = rate.Cheapest();
  for (const PolicySummary* policy : ByCost(rate)) {
    const bool is_never = policy->policy.kind == Policy::Kind::kNever;
    const Comparison comparison = Compare(*policy, cheapest, lives);
    table.AddRow({ShortName(policy->policy), Money(policy->cost),
                  policy == cheapest ? "–" : Money(policy->over_cheapest),
                  comparison.words, is_never ? "–" : Money(policy->saving),
                  is_never ? "–" : Percent(policy->share_saved)});
    table.levels.push_back({0, 0, 0, comparison.level, 0, 0});
  }
  return table;
}

Table ActivityTable(const RateSummary& rate) {
  Table table{.caption = absl::StrCat(
                  RateTitle(rate),
                  ": what each policy does in a life, and the errors of its "
                  "model at the set-point changes"),
              .columns = {{"policy", Align::kLeft},
                          {"updates"},
                          {"refused"},
                          {"reverted"},
                          {"no change found"},
                          {"step tests"},
                          {"mean E"},
                          {"mean gain error"},
                          {"mean dead-time error"}}};
  for (const PolicySummary& policy : rate.policies) {
    std::vector<std::string> cells = {policy.policy.name};
    for (const double count : {policy.updates, policy.refusals, policy.reverted,
                               policy.unchanged, policy.tests}) {
      cells.push_back(FormatFixed(count, 1));
    }
    cells.push_back(FormatSignificant(policy.distance));
    cells.push_back(Percent(policy.gain_error));
    cells.push_back(FormatSignificant(policy.delay_error));
    table.AddRow(std::move(cells));
  }
  return table;
}

Table CostTable(const RateSummary& rate, const std::string& currency) {
  Table table{
      .caption = absl::StrCat(RateTitle(rate), ": parts of the cost of a year",
                              InCurrency(currency)),
      .columns = {{"policy", Align::kLeft},
                  {"off set point"},
                  {"beyond limits"},
                  {"input moves"},
                  {"hours of step test"},
                  {"engineers"},
                  {"all"}}};
  for (const PolicySummary* policy : ByCost(rate)) {
    const control::Cost& parts = policy->parts;
    table.AddRow({ShortName(policy->policy), report::FormatMoney(parts.product),
                  report::FormatMoney(parts.violation),
                  report::FormatMoney(parts.movement),
                  report::FormatMoney(parts.test_hours),
                  report::FormatMoney(parts.engineering),
                  report::FormatMoney(parts.total())});
  }
  return table;
}

Table SavingTable(const std::vector<RateSummary>& summaries,
                  const std::string& currency) {
  Table table{.caption = absl::StrCat(
                  "Saving a year against never updating", InCurrency(currency),
                  ", by policy and rate of ageing, with the half-width of its "
                  "95 % interval. The darker, the larger the share of the "
                  "largest saving at that rate; without colour: not "
                  "significantly above zero"),
              .columns = {{"policy", Align::kLeft}}};
  const std::vector<const RateSummary*> by_rate = ByRate(summaries);
  for (const RateSummary* rate : by_rate) {
    table.columns.push_back({absl::StrCat("rate ", rate->rate)});
  }
  for (std::size_t p = 0; p < summaries.front().policies.size(); ++p) {
    const Policy& policy = summaries.front().policies[p].policy;
    if (policy.kind == Policy::Kind::kNever) continue;
    std::vector<std::string> cells = {ShortName(policy)};
    std::vector<int> levels = {0};
    for (const RateSummary* rate : by_rate) {
      const PolicySummary& at = rate->policies[p];
      const MeanOfSeeds& saving = at.saving;
      cells.push_back(
          at.ran_away > 0
              ? "the loop diverged"
              : absl::StrCat(saving.mean > 0.0 ? "+" : "", Money(saving)));
      levels.push_back(Pays(saving)
                           ? static_cast<int>(std::ceil(kDarkest * saving.mean /
                                                        LargestSaving(*rate)))
                           : 0);
    }
    table.AddRow(std::move(cells));
    table.levels.push_back(std::move(levels));
  }
  return table;
}

std::string Money(const MeanOfSeeds& amount, const std::string& currency) {
  std::string text = report::FormatMoney(amount.mean);
  if (std::isfinite(amount.half_width)) {
    absl::StrAppend(&text, " ± ", report::FormatMoney(amount.half_width));
  }
  return absl::StrCat(text, currency.empty() ? "" : " ", currency);
}

std::string InCurrency(const std::string& currency) {
  return currency.empty() ? "" : absl::StrCat(", ", currency);
}

}  // namespace mle::lifecycle
