#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/report.h"
#include "apps/lifecycle/request.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/number.h"

namespace mle::lifecycle {
namespace {

using report::Figure;
using report::NamedFigure;
using report::Panel;
using report::Role;
using report::Series;

constexpr double kColumnWidthCm = 8.5;
constexpr double kDaysPerYear = kHoursPerYear / 24.0;

// Mean months between updates or tests; NaN for those without an interval.
double MonthsBetween(const Policy& policy, double change_months) {
  switch (policy.kind) {
    case Policy::Kind::kCorrection:
      return policy.every * change_months;
    case Policy::Kind::kTest:
      return policy.months;
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

std::string FamilyName(const std::string& family) {
  if (family == "test") return "step test";
  if (family == "output_error") return "corrected";
  return family == "arx" ? "ΔR" : family;
}

// One line for each family that has an interval.
void FillIntervalPanel(const RateSummary& rate, double change_months,
                       const std::string& currency, Panel& panel) {
  panel.x = {.label = "months between updates", .log = true};
  panel.y = {.label = CostLabel(rate, currency)};
  UpperEdge upper;
  double lower = 0.0;
  for (const PolicySummary& policy : rate.policies) {
    const MeanOfSeeds drawn = Drawn(policy);
    const double half =
        std::isfinite(drawn.half_width) && !policy.policy.tests()
            ? drawn.half_width
            : 0.0;
    upper.Add(policy.policy, drawn.mean + half);
    if (!policy.policy.tests()) lower = std::min(lower, drawn.mean - half);
  }
  if (upper.value() > lower) panel.y.range = {{lower, upper.value()}};
  std::map<std::string, std::vector<const PolicySummary*>> families;
  for (const PolicySummary& policy : rate.policies) {
    if (std::isfinite(MonthsBetween(policy.policy, change_months))) {
      families[policy.policy.family()].push_back(&policy);
    }
  }
  for (auto& [family, members] : families) {
    std::sort(members.begin(), members.end(),
              [&](const auto* a, const auto* b) {
                return MonthsBetween(a->policy, change_months) <
                       MonthsBetween(b->policy, change_months);
              });
    Series series;
    series.label = FamilyName(family);
    series.style = StyleOfPolicy(members.front()->policy, 0);
    series.style.marker = MarkerOf(family);
    series.style.marker_size_pt = 6.0;
    for (const PolicySummary* policy : members) {
      series.x.push_back(MonthsBetween(policy->policy, change_months));
      const MeanOfSeeds drawn = Drawn(*policy);
      const double half =
          std::isfinite(drawn.half_width) ? drawn.half_width : 0.0;
      series.y.push_back(drawn.mean);
      series.lower.push_back(drawn.mean - half);
      series.upper.push_back(drawn.mean + half);
    }
    panel.series.push_back(std::move(series));
  }
  for (const PolicySummary& policy : rate.policies) {
    const std::string family = policy.policy.family();
    if (family != "never" && family != "perfect" && family != "on_demand") {
      continue;
    }
    panel.lines.push_back({.label = family == "perfect"
                                        ? std::string(kFloorLabel)
                                        : ShortName(policy.policy),
                           .value = Drawn(policy).mean,
                           .style = StyleOfPolicy(policy.policy, 1)});
  }
}

NamedFigure IntervalFigure(const std::vector<RateSummary>& summaries,
                           double change_months, const std::string& currency) {
  NamedFigure named;
  named.name = "cost_over_interval";
  named.caption =
      "Cost of a year above the perfect model, the floor (whole cost where "
      "that policy is not run), against the time between updates, a panel "
      "for each rate of ageing; means and 95 % bands over the same lives. "
      "Step tests that cost several times as much as all others are beyond "
      "the upper edge.";
  Figure& figure = named.figure;
  figure.columns = std::min(static_cast<int>(summaries.size()), 2);
  const int rows = (static_cast<int>(summaries.size()) + figure.columns - 1) /
                   figure.columns;
  figure.width_cm = figure.columns == 1 ? 13.0 : 2.0 * kColumnWidthCm;
  figure.height_cm = 2.0 + 6.0 * rows;
  for (const RateSummary& rate : summaries) {
    FillIntervalPanel(rate, change_months, currency,
                      figure.AddPanel(absl::StrCat("ageing rate ", rate.rate)));
  }
  return named;
}

std::vector<const RateSummary*> ByRate(
    const std::vector<RateSummary>& summaries) {
  std::vector<const RateSummary*> sorted;
  for (const RateSummary& rate : summaries) sorted.push_back(&rate);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto* a, const auto* b) { return a->rate < b->rate; });
  return sorted;
}

// `summaries`: by rising rate.
NamedFigure RateFigure(const Campaign& campaign,
                       const std::vector<const RateSummary*>& summaries,
                       const std::string& currency) {
  NamedFigure named;
  named.name = "cost_over_rate";
  named.caption =
      "Cost of a year above the perfect model, the floor (whole cost where "
      "that policy is not run), against the rate of ageing, a line for each "
      "policy; means over the lives. Step tests that cost several times as "
      "much as all others are beyond the upper edge.";
  Figure& figure = named.figure;
  figure.width_cm = 15.0;
  figure.height_cm = 9.5;
  Panel& panel = figure.AddPanel("");
  panel.x = {.label = "rate of ageing"};
  panel.y = {.label = CostLabel(*summaries.front(), currency)};
  UpperEdge upper;
  double lower = 0.0;
  for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
    Series series;
    series.label = ShortName(campaign.policies[p]);
    series.style = StyleAt(campaign.policies, p);
    series.style.marker = MarkerOf(campaign.policies[p].family());
    for (const RateSummary* rate : summaries) {
      series.x.push_back(rate->rate);
      const double cost = Drawn(rate->policies[p]).mean;
      series.y.push_back(cost);
      upper.Add(campaign.policies[p], cost);
      if (!campaign.policies[p].tests()) lower = std::min(lower, cost);
    }
    panel.series.push_back(std::move(series));
  }
  if (upper.value() > lower) panel.y.range = {{lower, upper.value()}};
  return named;
}

// Of the perfect policy, by change; empty where it is not run.
std::vector<double> PerfectCosts(const Campaign& campaign,
                                 const std::vector<Life>& lives,
                                 const Valuation& valuation) {
  std::vector<double> perfect;
  for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
    if (campaign.policies[p].kind != Policy::Kind::kPerfect) continue;
    for (const ChangeRow& row : lives[p].rows) {
      perfect.push_back(
          CostOf(row, valuation.prices, valuation.hours_per_unit).total());
    }
  }
  return perfect;
}

NamedFigure TimeFigure(const Campaign& campaign,
                       const std::vector<std::vector<Life>>& lives, double rate,
                       const Valuation& valuation) {
  NamedFigure named;
  named.name = "over_time";
  named.caption = absl::StrCat(
      "Over the years, seed ", campaign.seeds.front(), ", ageing rate ", rate,
      ": cost so far above the perfect model, the floor (whole cost where "
      "that policy is not run), and the squared distance E of "
      "the model in use from the plant. Step tests may exceed the range "
      "shown.");
  Figure& figure = named.figure;
  figure.columns = 1;
  figure.width_cm = 2.0 * kColumnWidthCm;
  figure.height_cm = 16.0;
  figure.panels = {Panel{.title = "Cost"},
                   Panel{.title = "Distance from the plant"}};
  Panel& cost = figure.panels[0];
  Panel& distance_panel = figure.panels[1];
  cost.x = {.label = "years"};
  cost.y = {.label = "cost so far"};
  distance_panel.x = {.label = "years"};
  distance_panel.y = {.label = "squared distance E", .log = true};
  const std::vector<double> perfect =
      PerfectCosts(campaign, lives.front(), valuation);
  if (!perfect.empty()) {
    cost.y.label = "cost so far above the floor";
    cost.lines.push_back(report::HorizontalLine(Role::kTrue, kFloorLabel, 0.0));
  }
  cost.y.label += InCurrency(valuation.currency);
  UpperEdge upper;
  double lower = 0.0;
  for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
    const bool is_perfect = campaign.policies[p].kind == Policy::Kind::kPerfect;
    if (is_perfect) continue;
    Series spent;
    spent.label = ShortName(campaign.policies[p]);
    spent.style = StyleAt(campaign.policies, p);
    Series distance = spent;
    double total = 0.0;
    const std::vector<ChangeRow>& rows = lives.front()[p].rows;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double years =
          rows[k].event.time * valuation.hours_per_unit / 24.0 / kDaysPerYear;
      total +=
          CostOf(rows[k], valuation.prices, valuation.hours_per_unit).total() -
          (k < perfect.size() ? perfect[k] : 0.0);
      spent.x.push_back(years);
      spent.y.push_back(total);
      if (!campaign.policies[p].tests()) lower = std::min(lower, total);
      distance.x.push_back(years);
      distance.y.push_back(rows[k].error.distance);
    }
    if (!spent.y.empty()) {
      upper.Add(campaign.policies[p],
                *std::max_element(spent.y.begin(), spent.y.end()));
    }
    cost.series.push_back(std::move(spent));
    distance_panel.series.push_back(std::move(distance));
  }
  if (upper.value() > lower) cost.y.range = {{lower, upper.value()}};
  return named;
}

}  // namespace

std::vector<NamedFigure> MakeFigures(const Campaign& campaign,
                                     const Lives& lives,
                                     const std::vector<RateSummary>& summaries,
                                     const Valuation& valuation) {
  std::vector<NamedFigure> figures;
  const double change_months =
      campaign.set_points.change_every / campaign.life.month;
  std::map<std::string, int> members;
  for (const Policy& policy : campaign.policies) {
    if (std::isfinite(MonthsBetween(policy, change_months))) {
      ++members[policy.family()];
    }
  }
  const bool several =
      std::any_of(members.begin(), members.end(),
                  [](const auto& family) { return family.second > 1; });
  figures.push_back(CostFigure(NominalRate(summaries), valuation.currency));
  if (several) {
    figures.push_back(
        IntervalFigure(summaries, change_months, valuation.currency));
  }
  const std::vector<const RateSummary*> by_rate = ByRate(summaries);
  if (summaries.size() > 1) {
    if (summaries.front().Find(Policy::Kind::kNever) != nullptr &&
        campaign.policies.size() > 1) {
      figures.push_back(SavingMap(by_rate, valuation.currency));
    }
    figures.push_back(RateFigure(campaign, by_rate, valuation.currency));
  }
  const std::size_t nearest = &NominalRate(summaries) - summaries.data();
  figures.push_back(
      TimeFigure(campaign, lives[nearest], summaries[nearest].rate, valuation));
  for (NamedFigure& figure : figures) {
    if (figure.alt.empty()) figure.alt = figure.caption;
  }
  return figures;
}

namespace {

constexpr double kCellWidthCm = 3.4;
constexpr double kCellHeightCm = 1.1;

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

std::vector<std::string> Words(const PolicySummary& policy) {
  if (policy.ran_away > 0) return {"the loop diverged"};
  const MeanOfSeeds& saving = policy.saving;
  if (!std::isfinite(saving.mean)) return {"–"};
  std::vector<std::string> lines = {absl::StrCat(
      saving.mean > 0.0 ? "+" : "", report::FormatMoney(saving.mean))};
  if (std::isfinite(saving.half_width)) {
    lines.push_back(absl::StrCat("± ", report::FormatMoney(saving.half_width)));
  }
  return lines;
}

}  // namespace

report::NamedFigure SavingMap(const std::vector<const RateSummary*>& summaries,
                              const std::string& currency) {
  report::NamedFigure named;
  named.name = "saving_map";
  named.caption = absl::StrCat(
      "Saving a year against never updating", InCurrency(currency),
      ", by policy and rate of ageing, with the half-width of its 95 % "
      "interval. The darker, the larger the share of the largest saving at "
      "that rate. White: not significantly above zero.");
  named.alt = absl::StrCat(named.caption, " The tables have the same numbers.");
  report::Panel& panel = named.figure.AddPanel("");
  panel.x.label = "rate of ageing";
  for (const RateSummary* rate : summaries) {
    panel.x.names.push_back(absl::StrCat(rate->rate));
  }
  const std::size_t policies = summaries.front()->policies.size();
  for (std::size_t p = policies; p-- > 0;) {
    const Policy& policy = summaries.front()->policies[p].policy;
    if (policy.kind == Policy::Kind::kNever) continue;
    const auto y = static_cast<double>(panel.y.names.size());
    panel.y.names.push_back(ShortName(policy));
    for (std::size_t r = 0; r < summaries.size(); ++r) {
      const PolicySummary& at = summaries[r]->policies[p];
      const double shade =
          Pays(at.saving) ? at.saving.mean / LargestSaving(*summaries[r]) : 0.0;
      panel.cells.push_back({static_cast<double>(r), y, shade, Words(at)});
    }
  }
  named.figure.legend = false;
  named.figure.width_cm = std::clamp(
      4.0 + kCellWidthCm * static_cast<double>(summaries.size()), 8.5, 60.0);
  named.figure.height_cm =
      1.8 + kCellHeightCm * static_cast<double>(panel.y.names.size());
  return named;
}

}  // namespace mle::lifecycle
