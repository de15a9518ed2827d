#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/experiment/report.h"
#include "apps/report/number.h"

namespace mle::experiment {
namespace {

using report::FormatInteger;
using report::FormatSignificant;

std::string Percent(double share) {
  return std::isnan(share)
             ? "–"
             : absl::StrCat(FormatSignificant(100.0 * share, 3), " %");
}

// "8.1 [7.6, 8.7]".
std::string MeanText(const Distribution& metric) {
  if (metric.count == 0) return "–";
  if (metric.count == 1) return FormatSignificant(metric.mean);
  return absl::StrCat(FormatSignificant(metric.mean), " [",
                      FormatSignificant(metric.mean_low), ", ",
                      FormatSignificant(metric.mean_high), "]");
}

std::string MedianText(const Distribution& metric) {
  return metric.count == 0 ? "–" : FormatSignificant(metric.median());
}

std::string SpanText(const Distribution& metric) {
  if (metric.count == 0) return "–";
  return absl::StrCat(FormatSignificant(metric.quantiles.front()), " … ",
                      FormatSignificant(metric.quantiles.back()));
}

// Rows first … first + most − 1 of the cells; a column of methods where there
// are several.
report::Table CellTable(const Campaign& campaign, const StudySummary& summary,
                        std::vector<report::Column> columns, Rows rows,
                        std::vector<std::string> (*values)(const Cell&)) {
  const bool several = campaign.methods.size() > 1;
  report::Table table;
  table.columns = {{"scenario", report::Align::kLeft}};
  if (several) table.columns.push_back({"method", report::Align::kLeft});
  for (report::Column& column : columns) {
    table.columns.push_back(std::move(column));
  }
  const std::size_t end =
      std::min(rows.first + rows.most, summary.cells.size());
  for (std::size_t i = rows.first; i < end; ++i) {
    const Cell& cell = summary.cells[i];
    std::vector<std::string> row = {ScenarioLabel(campaign, cell.at.scenario)};
    if (several) {
      row.push_back(MethodLabel(campaign, campaign.methods[cell.at.method]));
    }
    for (std::string& value : values(cell)) row.push_back(std::move(value));
    table.AddRow(std::move(row));
  }
  return table;
}

}  // namespace

report::Table MethodTable(const Campaign& campaign,
                          const StudySummary& summary) {
  report::Table table;
  table.caption =
      "Methods over all scenarios. Left: E after over E before, medians over "
      "the seeds";
  table.columns = {{"method", report::Align::kLeft},
                   {"scenarios"},
                   {"closer"},
                   {"unchanged"},
                   {"farther"},
                   {"closest of all"},
                   {"left of E"},
                   {"worst scenario"},
                   {"runs harmed"}};
  for (const MethodTally& tally : TallyMethods(campaign, summary)) {
    const double share =
        tally.runs > 0 ? tally.harmed / static_cast<double>(tally.runs) : NAN;
    table.AddRow({MethodLabel(campaign, campaign.methods[tally.method]),
                  absl::StrCat(tally.cases()), absl::StrCat(tally.closer),
                  absl::StrCat(tally.unchanged), absl::StrCat(tally.farther),
                  absl::StrCat(tally.closest), Percent(tally.middle_ratio),
                  Percent(tally.worst_ratio), Percent(share)});
    table.levels.push_back({0, 0, 0, 0, tally.farther > 0 ? 2 : 0});
  }
  return table;
}

report::Table ErrorTable(const Campaign& campaign, const StudySummary& summary,
                         Rows rows) {
  report::Table table = CellTable(
      campaign, summary,
      {{"runs"},
       {"E before"},
       {"E"},
       {"5 … 95 %"},
       {"E at best λ"},
       {"harmed"}},
      rows, [](const Cell& cell) -> std::vector<std::string> {
        const Distribution& E = cell[Metric::kE];
        return {cell.failed == 0
                    ? FormatInteger(cell.runs)
                    : absl::StrCat(cell.runs, ", ", cell.failed, " failed"),
                MedianText(cell[Metric::kInitialE]),
                MedianText(E),
                SpanText(E),
                MedianText(cell[Metric::kBestE]),
                Percent(cell.harmed)};
      });
  table.caption =
      "Squared distance E, medians over the seeds; harmed: runs with E above "
      "that of the initial model";
  return table;
}

report::Table MeanTable(const Campaign& campaign, const StudySummary& summary,
                        Rows rows) {
  report::Table table = CellTable(
      campaign, summary, {{"mean"}, {"smallest"}, {"largest"}}, rows,
      [](const Cell& cell) -> std::vector<std::string> {
        const Distribution& E = cell[Metric::kE];
        return {MeanText(E), E.count == 0 ? "–" : FormatSignificant(E.min),
                E.count == 0 ? "–" : FormatSignificant(E.max)};
      });
  table.caption =
      "Squared distance E: means, with 95 % intervals by the bootstrap over "
      "the seeds, and extremes";
  return table;
}

report::Table LambdaTable(const Campaign& campaign, const StudySummary& summary,
                          Rows rows) {
  report::Table table = CellTable(
      campaign, summary,
      {{"best λ"},
       {"5 … 95 %"},
       {"λ chosen"},
       {"5 … 95 %"},
       {"E / E at best λ"},
       {"95 %; largest"},
       {"above 2"}},
      rows, [](const Cell& cell) -> std::vector<std::string> {
        const Distribution& ratio = cell[Metric::kRatio];
        return {MedianText(cell[Metric::kBestLambda]),
                SpanText(cell[Metric::kBestLambda]),
                MedianText(cell[Metric::kLambdaMin]),
                SpanText(cell[Metric::kLambdaMin]),
                MedianText(ratio),
                ratio.count == 0
                    ? "–"
                    : absl::StrCat(FormatSignificant(ratio.quantiles.back()),
                                   "; ", FormatSignificant(ratio.max)),
                Percent(cell.above_twice_best)};
      });
  table.caption = "λ over the seeds: medians, unless said";
  return table;
}

report::Table ElementTable(const Campaign& campaign,
                           const StudySummary& summary, Rows rows) {
  report::Table table = CellTable(
      campaign, summary,
      {{"gain error"},
       {"95 %"},
       {"dead-time error"},
       {"95 %"},
       {"change proposed"}},
      rows, [](const Cell& cell) -> std::vector<std::string> {
        const Distribution& gain = cell[Metric::kGainErrorRms];
        const Distribution& delay = cell[Metric::kDelayErrorRms];
        return {
            gain.count == 0 ? "–" : Percent(gain.median()),
            gain.count == 0 ? "–" : Percent(gain.quantiles.back()),
            MedianText(delay),
            delay.count == 0 ? "–" : FormatSignificant(delay.quantiles.back()),
            cell[Metric::kProposed].count == 0
                ? "–"
                : Percent(cell[Metric::kProposed].mean)};
      });
  table.caption =
      "Errors of first-order fits, RMS over the elements, gains relative to "
      "the plant's: medians over the seeds, unless said";
  return table;
}

report::Table FailureTable(const StudySummary& summary) {
  report::Table table;
  table.caption = "Runs that failed";
  table.columns = {{"why (# stands for a number)", report::Align::kLeft},
                   {"runs"}};
  for (const auto& [kind, count] : summary.failures) {
    table.AddRow({kind, FormatInteger(count)});
  }
  return table;
}

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
    const Ablation* const ablation = campaign.ablations[scenario.ablation];
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
  if (campaign.controllers.size() > 1) {
    parts.push_back(campaign.controllers[scenario.controller].name);
  }
  if (campaign.windows.size() > 1) {
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

}  // namespace mle::experiment
