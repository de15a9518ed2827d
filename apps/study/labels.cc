#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/study/report.h"

namespace mle::study {

using experiment::Campaign;
using experiment::Method;
using experiment::Mismatch;
using experiment::Scenario;

std::string ScenarioLabel(const Campaign& campaign, const Scenario& scenario) {
  return ScenarioLabel(campaign, scenario, Axis::kNone);
}

std::string ScenarioLabel(const Campaign& campaign, const Scenario& scenario,
                          Axis without) {
  std::vector<std::string> parts;
  const Mismatch& mismatch = campaign.mismatches[scenario.mismatch];
  bool sizes = false;
  for (const Mismatch& other : campaign.mismatches) {
    sizes =
        sizes || (other.name == mismatch.name && other.size != mismatch.size);
  }
  parts.push_back(mismatch.name);
  if (sizes && without != Axis::kSize) {
    parts.back() += absl::StrCat("\u00a0×\u00a0", mismatch.size);
  }
  if (campaign.models.size() > 1) {
    parts.push_back(campaign.models[scenario.model].name);
  }
  if (campaign.noise_variances.size() > 1 && without != Axis::kNoise) {
    parts.push_back(
        absl::StrCat("σ² ", campaign.noise_variances[scenario.noise]));
  }
  if (campaign.ablations.size() > 1) {
    const experiment::Ablation* const ablation =
        campaign.ablations[scenario.ablation];
    parts.emplace_back(ablation == nullptr ? "no ablation" : ablation->name);
  }
  if (campaign.drift_variances.size() > 1 && without != Axis::kDrift) {
    parts.push_back(
        absl::StrCat("q ", campaign.drift_variances[scenario.drift]));
  }
  if (campaign.effects.size() > 1) {
    const std::string& name = campaign.effects[scenario.effects].name;
    parts.push_back(name == "none" ? "no effects" : name);
  }
  if (campaign.controllers.size() > 1 && without != Axis::kController) {
    parts.push_back(campaign.controllers[scenario.controller].name);
  }
  if (campaign.windows.size() > 1 && without != Axis::kWindows) {
    parts.push_back(campaign.windows[scenario.windows].name);
  }
  return absl::StrJoin(parts, ", ");
}

std::string MethodLabel(const Campaign& campaign, const Method& method) {
  std::vector<std::string> parts = {method.name()};
  if (method.selection >= 0 && campaign.selections.size() > 1) {
    parts.push_back(campaign.selections[method.selection].name);
  }
  if (method.solver >= 0 && campaign.solvers.size() > 1) {
    parts.push_back(campaign.solvers[method.solver].name);
  }
  return absl::StrJoin(parts, ", ");
}

}  // namespace mle::study
