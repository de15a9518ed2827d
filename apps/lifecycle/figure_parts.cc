#include "apps/lifecycle/figure_parts.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/money.h"

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

}  // namespace mle::lifecycle
