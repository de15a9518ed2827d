#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/report.h"

namespace mle::lifecycle {

using report::LineStyle;
using report::MarkerShape;
using report::Role;
using report::Style;

Style StyleOfPolicy(const Policy& policy, int member) {
  static const std::map<std::string, Role>* const kColours =
      new std::map<std::string, Role>{
          {"never", Role::kInitial},          {"perfect", Role::kTrue},
          {"output_error", Role::kCorrected}, {"combined", Role::kFitted},
          {"arx", Role::kAlternative},        {"test", Role::kUnregularised},
          {"on_demand", Role::kMeasured}};
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

Style StyleAt(const std::vector<Policy>& policies, std::size_t place) {
  int member = 0;
  for (std::size_t i = 0; i < place; ++i) {
    if (policies[i].family() == policies[place].family()) ++member;
  }
  return StyleOfPolicy(policies[place], member);
}

MarkerShape MarkerOf(const std::string& family) {
  if (family == "output_error") return MarkerShape::kDisc;
  if (family == "combined") return MarkerShape::kSquare;
  if (family == "arx") return MarkerShape::kTriangle;
  return MarkerShape::kDiamond;
}

MeanOfSeeds Drawn(const PolicySummary& policy) {
  return std::isfinite(policy.excess.mean) ? policy.excess : policy.cost;
}

std::string CostLabel(const RateSummary& rate, const std::string& currency) {
  return absl::StrCat(rate.Find(Policy::Kind::kPerfect) != nullptr
                          ? "cost a year above the floor"
                          : "cost a year",
                      InCurrency(currency));
}

void UpperEdge::Add(const Policy& policy, double cost) {
  if (!std::isfinite(cost)) return;
  if (policy.tests()) {
    tests_ = std::min(tests_, cost);
  } else {
    others_ = std::max(others_, cost);
  }
}

double UpperEdge::value() const {
  const double tests = tests_ <= kMostTimes * others_ ? tests_ : others_;
  return 1.15 * std::max(others_, tests);
}

namespace {

using report::MarkerShape;
using report::Panel;
using report::Series;

// Policies with a known cost, the dearest first, which is the lowest in the
// figure. The perfect model is the edge they are measured from.
std::vector<const PolicySummary*> Shown(const RateSummary& rate) {
  std::vector<const PolicySummary*> shown;
  for (const PolicySummary& policy : rate.policies) {
    const bool is_floor = policy.policy.kind == Policy::Kind::kPerfect;
    if (!is_floor && std::isfinite(Drawn(policy).mean)) {
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
  marker.style.marker = MarkerOf(policy.policy.family());
  marker.style.marker_size_pt = 6.0;
  if (cost.mean > edge) {
    marker.label = "beyond the right edge";
    marker.x = edge;
    marker.style.marker = MarkerShape::kCross;
  }
  panel.markers.push_back(std::move(marker));
}

}  // namespace

report::NamedFigure CostFigure(const RateSummary& rate,
                               const std::string& currency) {
  report::NamedFigure named;
  named.name = "policy_costs";
  named.caption = absl::StrCat(
      "What each policy costs a year above the perfect model, which is the "
      "floor (the whole cost where that policy is not run), ageing rate ",
      rate.rate,
      "; points are means, lines 95 % intervals over the same lives.");
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
    panel.lines.push_back({.label = kFloorLabel,
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

}  // namespace mle::lifecycle
