#include "apps/lifecycle/saving_map.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/money.h"
#include "apps/lifecycle/policy_words.h"
#include "apps/report/number.h"

namespace mle::lifecycle {
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
