// What the figures of lives have in common.

#ifndef APPS_LIFECYCLE_FIGURE_PARTS_H_
#define APPS_LIFECYCLE_FIGURE_PARTS_H_

#include <limits>
#include <string>
#include <vector>

#include "apps/lifecycle/policy.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/drawing.h"
#include "apps/report/figure.h"

namespace mle::lifecycle {

inline constexpr char kFloorLabel[] = "perfect model: the floor";

// Colour by family; its members differ in their lines.
report::Style StyleOfPolicy(const Policy& policy, int member);
// By its place among the policies.
report::Style StyleAt(const std::vector<Policy>& policies, std::size_t place);

report::MarkerShape MarkerOf(const std::string& family);

// What is drawn of a policy: what it costs beyond the perfect model, where that
// is known.
MeanOfSeeds Drawn(const PolicySummary& policy);

// "cost a year above the floor, EUR", or the cost itself without the perfect
// model.
std::string CostLabel(const RateSummary& rate, const std::string& currency);

// The highest cost that a picture has to show. Step tests may cost many times
// what all others do, and would press those flat.
class UpperEdge {
 public:
  void Add(const Policy& policy, double cost);
  double value() const;

 private:
  static constexpr double kMostTimes = 4.0;
  double others_ = 0.0;
  double tests_ = std::numeric_limits<double>::infinity();
};

// What each policy costs a year at one rate, with its interval, above the floor
// that the perfect model is (cost_figure.cc).
report::NamedFigure CostFigure(const RateSummary& rate,
                               const std::string& currency);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_FIGURE_PARTS_H_
