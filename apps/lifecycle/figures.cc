#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/report.h"
#include "apps/lifecycle/request.h"
#include "apps/lifecycle/summary.h"

namespace mle::lifecycle {
namespace {

using report::Figure;
using report::LineStyle;
using report::MarkerShape;
using report::NamedFigure;
using report::Panel;
using report::Role;
using report::Series;
using report::Style;

constexpr double kWidthCm = 17.0;
constexpr double kDaysPerYear = kHoursPerYear / 24.0;
// Colour by family; its members differ in their lines.
Style StyleOfPolicy(const Policy& policy, int member) {
  static const std::map<std::string, Role>* const kColours =
      new std::map<std::string, Role>{
          {"never", Role::kInitial},          {"perfect", Role::kTrue},
          {"output_error", Role::kCorrected}, {"arx", Role::kAlternative},
          {"test", Role::kUnregularised},     {"on_demand", Role::kMeasured}};
  constexpr LineStyle kLines[] = {LineStyle::kSolid, LineStyle::kDashed,
                                  LineStyle::kDotted, LineStyle::kDashDotted};
  Style style;
  const auto colour = kColours->find(policy.family());
  if (colour != kColours->end()) style.colour = colour->second;
  style.line = kLines[member % 4];
  // Drawn first, and where another policy costs the same, on both its sides.
  style.width_pt = policy.kind == Policy::Kind::kNever ? 3.0 : 1.4;
  return style;
}

// By its place among the policies.
Style StyleAt(const std::vector<Policy>& policies, std::size_t place) {
  int member = 0;
  for (std::size_t i = 0; i < place; ++i) {
    if (policies[i].family() == policies[place].family()) ++member;
  }
  return StyleOfPolicy(policies[place], member);
}

// The cost of a policy beyond the perfect model's, where that is known; else
// its whole cost.
MeanOfSeeds Drawn(const PolicySummary& policy) {
  return std::isfinite(policy.excess.mean) ? policy.excess : policy.cost;
}

// "cost a year above the reference, EUR", or the cost itself without the
// perfect model.
std::string CostLabel(const RateSummary& rate, const std::string& currency) {
  return absl::StrCat(rate.Find(Policy::Kind::kPerfect) != nullptr
                          ? "cost a year above the reference"
                          : "cost a year",
                      InCurrency(currency));
}

// The highest cost that a picture has to show. Step tests may cost many times
// what all others do, and would press those flat.
class UpperEdge {
 public:
  void Add(const Policy& policy, double cost) {
    if (!std::isfinite(cost)) return;
    if (policy.tests()) {
      tests_ = std::min(tests_, cost);
    } else {
      others_ = std::max(others_, cost);
    }
  }
  double value() const {
    const double tests = tests_ <= kMostTimes * others_ ? tests_ : others_;
    return 1.15 * std::max(others_, tests);
  }

 private:
  static constexpr double kMostTimes = 4.0;
  double others_ = 0.0;
  double tests_ = std::numeric_limits<double>::infinity();
};

// Policies with a known cost, the dearest first, which is the lowest in the
// figure. The perfect model is the edge they are measured from.
std::vector<const PolicySummary*> Shown(const RateSummary& rate) {
  std::vector<const PolicySummary*> shown;
  for (const PolicySummary& policy : rate.policies) {
    const bool is_reference = policy.policy.kind == Policy::Kind::kPerfect;
    if (!is_reference && std::isfinite(Drawn(policy).mean)) {
      shown.push_back(&policy);
    }
  }
  std::stable_sort(shown.begin(), shown.end(),
                   [](const auto* a, const auto* b) {
                     return Drawn(*a).mean > Drawn(*b).mean;
                   });
  return shown;
}

// The interval as a line, the mean as a point on it.
void AddPolicy(const PolicySummary& policy, double place, double edge,
               Panel& panel) {
  const MeanOfSeeds cost = Drawn(policy);
  const double half = std::isfinite(cost.half_width) ? cost.half_width : 0.0;
  Series series;
  series.style = StyleOfPolicy(policy.policy, 0);
  series.style.width_pt = 2.0;
  series.x = {cost.mean - half, cost.mean + half};
  series.y = {place, place};
  panel.series.push_back(series);
  report::Marker marker{
      .label = "", .x = cost.mean, .y = place, .style = series.style};
  marker.style.marker = MarkerShape::kDisc;
  marker.style.marker_size_pt = 6.0;
  if (cost.mean > edge) {
    marker.label = "beyond the right edge";
    marker.x = edge;
    marker.style.marker = MarkerShape::kCross;
  }
  panel.markers.push_back(std::move(marker));
}

NamedFigure TimeFigure(const Campaign& campaign,
                       const std::vector<std::vector<Life>>& lives, double rate,
                       const Valuation& valuation) {
  NamedFigure named{
      .name = "over_time",
      .caption = absl::StrCat(
          "Over the years, seed ", campaign.seeds.front(), ", ageing rate ",
          rate,
          ": cost so far above the perfect model, the reference (whole cost "
          "where "
          "that policy is not run), and the squared distance E of the model in "
          "use from the plant. Step tests may exceed the range shown.")};
  Figure& figure = named.figure;
  figure.columns = 1;
  figure.width_cm = kWidthCm;
  figure.height_cm = 16.0;
  figure.panels = {Panel{.title = "Cost"},
                   Panel{.title = "Distance from the plant"}};
  Panel& cost = figure.panels[0];
  Panel& distance_panel = figure.panels[1];
  cost.x = {.label = "years"};
  cost.y = {.label = "cost so far"};
  distance_panel.x = {.label = "years"};
  distance_panel.y = {.label = "squared distance E", .log = true};
  const auto cost_of = [&valuation](const ChangeRow& row) {
    return CostOf(row, valuation.prices, valuation.hours_per_unit).total();
  };
  const std::size_t reference =
      PlaceOf(Policy::Kind::kPerfect, campaign.policies);
  std::vector<double> perfect;  // by change; empty where it is not run
  if (reference < campaign.policies.size()) {
    for (const ChangeRow& row : lives.front()[reference].rows) {
      perfect.push_back(cost_of(row));
    }
  }
  if (!perfect.empty()) {
    cost.y.label = "cost so far above the reference";
    cost.lines.push_back(
        report::HorizontalLine(Role::kTrue, kReferenceLabel, 0.0));
  }
  cost.y.label += InCurrency(valuation.currency);
  UpperEdge upper;
  double lower = 0.0;
  for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
    if (p == reference) continue;
    Series spent;
    spent.label = ShortName(campaign.policies[p]);
    spent.style = StyleAt(campaign.policies, p);
    Series distance = spent;
    double total = 0.0;
    const std::vector<ChangeRow>& rows = lives.front()[p].rows;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double years =
          rows[k].event.time * valuation.hours_per_unit / 24.0 / kDaysPerYear;
      total += cost_of(rows[k]) - (k < perfect.size() ? perfect[k] : 0.0);
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

report::NamedFigure CostFigure(const RateSummary& rate,
                               const std::string& currency) {
  report::NamedFigure named{
      .name = "policy_costs",
      .caption = absl::StrCat(
          "What each policy costs a year above the perfect model, which is the "
          "reference (the whole cost where that policy is not run), ageing "
          "rate ",
          rate.rate,
          "; points are means, lines 95 % intervals over the same lives.")};
  named.alt = absl::StrCat(named.caption, " The table has the same numbers.");
  Panel& panel = named.figure.AddPanel("");
  panel.x.label = CostLabel(rate, currency);
  const std::vector<const PolicySummary*> shown = Shown(rate);
  UpperEdge upper;
  double lower = 0.0;
  for (const PolicySummary* policy : shown) {
    const MeanOfSeeds cost = Drawn(*policy);
    const double half = std::isfinite(cost.half_width) ? cost.half_width : 0.0;
    upper.Add(policy->policy, cost.mean + half);
    lower = std::min(lower, 1.1 * (cost.mean - half));
  }
  if (upper.value() > lower) panel.x.range = {{lower, upper.value()}};
  const double edge = upper.value() > lower ? upper.value() : INFINITY;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    panel.y.names.push_back(ShortName(shown[k]->policy));
    AddPolicy(*shown[k], static_cast<double>(k), edge, panel);
  }
  const PolicySummary* perfect = rate.Find(Policy::Kind::kPerfect);
  if (perfect != nullptr && std::isfinite(perfect->excess.mean)) {
    panel.lines.push_back({.label = kReferenceLabel,
                           .orientation = report::Orientation::kVertical,
                           .value = 0.0,
                           .style = StyleOfPolicy(perfect->policy, 0)});
    panel.lines.back().style.width_pt = 3.0;
  }
  named.figure.width_cm = 15.0;
  named.figure.height_cm =
      std::min(2.4 + 0.75 * static_cast<double>(shown.size()), 60.0);
  return named;
}

std::vector<NamedFigure> MakeFigures(const Campaign& campaign,
                                     const Lives& lives,
                                     const std::vector<RateSummary>& summaries,
                                     const Valuation& valuation) {
  const RateSummary& nominal = NominalRate(summaries);
  return {CostFigure(nominal, valuation.currency),
          TimeFigure(campaign, lives[&nominal - summaries.data()], nominal.rate,
                     valuation)};
}

}  // namespace mle::lifecycle
