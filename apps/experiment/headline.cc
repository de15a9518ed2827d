#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/experiment/report.h"
#include "apps/report/text.h"

namespace mle::experiment {
namespace {

using report::Badge;
using report::FormatInteger;
using report::FormatSignificant;

enum class Ending { kCloser, kUnchanged, kFarther };

// `cell` is a case: it has values of E.
Ending EndingOf(const Cell& cell) {
  const double before = cell[Metric::kInitialE].median();
  const double after = cell[Metric::kE].median();
  if (after < before) return Ending::kCloser;
  return after > before ? Ending::kFarther : Ending::kUnchanged;
}

// Whether the cell is a case, and not a model left as it is or a cell in which
// every run failed.
bool IsCase(const Campaign& campaign, const Cell& cell) {
  return campaign.methods[cell.at.method].estimator.has_value() &&
         cell[Metric::kE].count > 0;
}

// More cases are told in tables.
constexpr std::size_t kMostCases = 3;

std::string CaseLabel(const Campaign& campaign, const Cell& cell) {
  return absl::StrCat(ScenarioLabel(campaign, cell.at.scenario), ", ",
                      MethodLabel(campaign, campaign.methods[cell.at.method]));
}

// "1 of 3 cases", "all 3 cases".
std::string OfCases(int count, int all) {
  if (count == all && all > 1) return absl::StrCat("all ", all, " cases");
  return absl::StrCat(count, " of ", all, all == 1 ? " case" : " cases");
}

MethodTally Total(const std::vector<MethodTally>& tallies) {
  MethodTally total;
  for (const MethodTally& tally : tallies) {
    total.closer += tally.closer;
    total.unchanged += tally.unchanged;
    total.farther += tally.farther;
    total.runs += tally.runs;
    total.harmed += tally.harmed;
  }
  return total;
}

report::Verdict Opening(const StudySummary& summary,
                        const MethodTally& totals) {
  if (summary.failed == summary.runs) {
    return {Badge::kUnknown, "failed", "Every run failed", {}};
  }
  if (totals.cases() == 0) {
    return {Badge::kUnknown,
            "no correction",
            "No model was corrected: nothing is compared",
            {}};
  }
  if (totals.closer == 0 && totals.farther == 0) {
    return {Badge::kGood,
            "unchanged",
            "Every correction leaves the model alone",
            {}};
  }
  if (totals.farther == 0) {
    return {
        Badge::kGood,
        "closer",
        absl::StrCat(
            totals.cases() == 1 ? "The correction ends" : "Corrections end",
            " closer to the plant",
            totals.cases() == 1
                ? ""
                : absl::StrCat(" in ", OfCases(totals.closer, totals.cases()))),
        {}};
  }
  return {totals.closer == 0 ? Badge::kChanged : Badge::kUnknown,
          totals.closer == 0 ? "farther" : "mixed",
          absl::StrCat("Corrections end farther from the plant in ",
                       OfCases(totals.farther, totals.cases()), ", closer in ",
                       totals.closer),
          {}};
}

// Each case by itself where there are few, or those that end farther.
std::string CaseSentence(const Campaign& campaign, const Cell& cell) {
  const Distribution& E = cell[Metric::kE];
  std::string sentence =
      absl::StrCat(CaseLabel(campaign, cell), ": E from ",
                   FormatSignificant(cell[Metric::kInitialE].median()), " to ",
                   FormatSignificant(E.median()));
  if (E.count > 1) {
    absl::StrAppend(&sentence, " (medians; nine of ten between ",
                    FormatSignificant(E.quantiles.front()), " and ",
                    FormatSignificant(E.quantiles.back()), ")");
  }
  return sentence + ".";
}

void AddCases(const Campaign& campaign, const StudySummary& summary,
              const MethodTally& totals, std::vector<std::string>& sentences) {
  const bool few = totals.cases() <= static_cast<int>(kMostCases);
  std::vector<std::string> farther;
  for (const Cell& cell : summary.cells) {
    if (!IsCase(campaign, cell)) continue;
    if (few) sentences.push_back(CaseSentence(campaign, cell));
    if (EndingOf(cell) == Ending::kFarther) {
      farther.push_back(CaseLabel(campaign, cell));
    }
  }
  if (few || farther.empty()) return;
  const std::size_t shown = std::min(farther.size(), kMostCases);
  std::string sentence = absl::StrCat(
      "Farther: ",
      absl::StrJoin(farther.begin(),
                    farther.begin() + static_cast<std::ptrdiff_t>(shown),
                    "; "));
  if (farther.size() > shown) {
    absl::StrAppend(&sentence, "; and ", farther.size() - shown, " more");
  }
  sentences.push_back(sentence + ".");
}

std::string HarmedSentence(const MethodTally& totals) {
  if (totals.runs == 0) return "";
  const double share = totals.harmed / static_cast<double>(totals.runs);
  return absl::StrCat(
      FormatInteger(std::llround(totals.harmed)), " of ",
      FormatInteger(totals.runs), " corrections (",
      FormatSignificant(100.0 * share, 2),
      " %) end farther from the plant than the initial model, seed by seed.");
}

std::string RunsSentence(const Campaign& campaign,
                         const StudySummary& summary) {
  const auto cells = static_cast<std::int64_t>(summary.cells.size());
  const auto seeds = static_cast<std::int64_t>(campaign.seeds.size());
  return absl::StrCat(
      FormatInteger(summary.runs),
      summary.runs == 1 ? " run: " : " runs: ", FormatInteger(cells),
      cells == 1 ? " cell" : " cells", " of the grid with ",
      FormatInteger(seeds), seeds == 1 ? " seed" : " seeds",
      cells == 1 ? ". " : " each. ",
      summary.failed == 0
          ? "None failed."
          : absl::StrCat(FormatInteger(summary.failed), " failed."));
}

// E after over E before, sorted.
void SetRatios(std::vector<double> ratios, MethodTally& tally) {
  tally.middle_ratio = tally.worst_ratio =
      std::numeric_limits<double>::quiet_NaN();
  if (ratios.empty()) return;
  std::sort(ratios.begin(), ratios.end());
  tally.middle_ratio = ratios[ratios.size() / 2];
  tally.worst_ratio = ratios.back();
}

// The smallest median E of the cases of each scenario.
std::map<std::int64_t, double> Smallest(const Campaign& campaign,
                                        const StudySummary& summary) {
  const auto methods = static_cast<std::int64_t>(campaign.methods.size());
  std::map<std::int64_t, double> smallest;
  for (const Cell& cell : summary.cells) {
    if (!IsCase(campaign, cell)) continue;
    const double median = cell[Metric::kE].median();
    const auto [place, is_new] =
        smallest.emplace(cell.number / methods, median);
    if (!is_new) place->second = std::min(place->second, median);
  }
  return smallest;
}

}  // namespace

std::vector<MethodTally> TallyMethods(const Campaign& campaign,
                                      const StudySummary& summary) {
  const std::map<std::int64_t, double> smallest = Smallest(campaign, summary);
  const auto methods = static_cast<std::int64_t>(campaign.methods.size());
  std::vector<MethodTally> tallies;
  for (int method = 0; method < methods; ++method) {
    if (!campaign.methods[method].estimator.has_value()) continue;
    MethodTally tally = {.method = method};
    std::vector<double> ratios;
    for (const Cell& cell : summary.cells) {
      if (cell.at.method != method || !IsCase(campaign, cell)) continue;
      const Ending ending = EndingOf(cell);
      tally.closer += ending == Ending::kCloser ? 1 : 0;
      tally.unchanged += ending == Ending::kUnchanged ? 1 : 0;
      tally.farther += ending == Ending::kFarther ? 1 : 0;
      const double before = cell[Metric::kInitialE].median();
      const double after = cell[Metric::kE].median();
      if (before > 0.0) ratios.push_back(after / before);
      if (after <= smallest.at(cell.number / methods)) ++tally.closest;
      const int runs = cell.runs - cell.failed;
      tally.runs += runs;
      if (std::isfinite(cell.harmed)) tally.harmed += runs * cell.harmed;
    }
    SetRatios(std::move(ratios), tally);
    tallies.push_back(tally);
  }
  return tallies;
}

report::Verdict VerdictOf(const Campaign& campaign,
                          const StudySummary& summary) {
  const MethodTally totals = Total(TallyMethods(campaign, summary));
  report::Verdict verdict = Opening(summary, totals);
  AddCases(campaign, summary, totals, verdict.sentences);
  verdict.sentences.push_back(HarmedSentence(totals));
  if (totals.cases() > 0) {
    verdict.sentences.emplace_back(
        "E is the squared distance of all step responses from the plant's; a "
        "case is a scenario with a method, judged by its median over the "
        "seeds.");
  }
  verdict.sentences.push_back(RunsSentence(campaign, summary));
  std::erase(verdict.sentences, "");
  return verdict;
}

std::string ScenarioLabel(const Campaign& campaign, const Scenario& scenario) {
  return ScenarioLabel(campaign, scenario, Axis::kNone);
}

std::string ScenarioLabel(const Campaign& campaign, const Scenario& scenario,
                          Axis without) {
  const Mismatch& mismatch = campaign.mismatches[scenario.mismatch];
  const bool sizes = std::any_of(
      campaign.mismatches.begin(), campaign.mismatches.end(),
      [&](const Mismatch& other) {
        return other.name == mismatch.name && other.size != mismatch.size;
      });
  std::vector<std::string> parts = {mismatch.name};
  if (sizes && without != Axis::kSize) {
    parts.back() += absl::StrCat("\u00a0×\u00a0", mismatch.size);
  }
  const auto add = [&](const auto& values, const std::string& text,
                       Axis axis = Axis::kNone) {
    const bool is_shown = axis == Axis::kNone || axis != without;
    if (values.size() > 1 && is_shown) parts.push_back(text);
  };
  const Ablation* const ablation = campaign.ablations[scenario.ablation];
  const std::string& effects = campaign.effects[scenario.effects].name;
  add(campaign.models, campaign.models[scenario.model].name);
  add(campaign.noise_variances,
      absl::StrCat("σ² ", campaign.noise_variances[scenario.noise]),
      Axis::kNoise);
  add(campaign.ablations, ablation == nullptr ? "no ablation" : ablation->name);
  add(campaign.drift_variances,
      absl::StrCat("q ", campaign.drift_variances[scenario.drift]),
      Axis::kDrift);
  add(campaign.effects, effects == "none" ? "no effects" : effects);
  add(campaign.controllers, campaign.controllers[scenario.controller].name);
  add(campaign.windows, campaign.windows[scenario.windows].name);
  return absl::StrJoin(parts, ", ");
}

std::string MethodLabel(const Campaign& campaign, const Method& method) {
  std::vector<std::string> parts = {method.estimator_name()};
  if (method.estimator.has_value() &&
      method.change_test != Method().change_test) {
    parts.push_back(
        method.change_test == ChangeTest::kNone
            ? "no test"
            : absl::StrCat(std::string(NameOf(method.change_test)), " test"));
  }
  if (method.selection >= 0 && campaign.selections.size() > 1) {
    parts.push_back(campaign.selections[method.selection].name);
  }
  if (method.solver >= 0 && campaign.solvers.size() > 1) {
    parts.push_back(campaign.solvers[method.solver].name);
  }
  return absl::StrJoin(parts, ", ");
}

}  // namespace mle::experiment
