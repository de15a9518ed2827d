#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/experiment/report.h"
#include "apps/report/text.h"

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
  if (metric.count == 1) return FormatSignificant(metric.mean);
  return absl::StrCat(FormatSignificant(metric.mean), " [",
                      FormatSignificant(metric.mean_low), ", ",
                      FormatSignificant(metric.mean_high), "]");
}

// A column of a table of cells.
struct CellColumn {
  const char* header;
  std::function<std::string(const Cell&)> text;
};

// Of a metric, where a run has it.
template <typename Text>
CellColumn ColumnOf(const char* header, Metric metric, const Text& text) {
  return {header, [=](const Cell& cell) {
            const Distribution& values = cell[metric];
            return values.count == 0 ? std::string("–") : text(values);
          }};
}

CellColumn MedianColumn(const char* header, Metric metric) {
  return ColumnOf(header, metric, [](const Distribution& values) {
    return FormatSignificant(values.median());
  });
}

CellColumn SpanColumn(Metric metric) {
  return ColumnOf("5 … 95 %", metric, [](const Distribution& values) {
    return absl::StrCat(FormatSignificant(values.quantiles.front()), " … ",
                        FormatSignificant(values.quantiles.back()));
  });
}

// Rows first … first + most − 1 of the cells; a column of methods where there
// are several.
report::Table CellTable(const Campaign& campaign, const StudySummary& summary,
                        Rows rows, const char* caption,
                        const std::vector<CellColumn>& columns) {
  const bool several = campaign.methods.size() > 1;
  report::Table table{.caption = caption,
                      .columns = {{"scenario", report::Align::kLeft}}};
  if (several) table.columns.push_back({"method", report::Align::kLeft});
  for (const CellColumn& column : columns) {
    table.columns.push_back({column.header});
  }
  const std::size_t end =
      std::min(rows.first + rows.most, summary.cells.size());
  for (std::size_t i = rows.first; i < end; ++i) {
    const Cell& cell = summary.cells[i];
    std::vector<std::string> row = {ScenarioLabel(campaign, cell.at.scenario)};
    if (several) {
      row.push_back(MethodLabel(campaign, campaign.methods[cell.at.method]));
    }
    for (const CellColumn& column : columns) row.push_back(column.text(cell));
    table.AddRow(std::move(row));
  }
  return table;
}

}  // namespace

report::Table MethodTable(const Campaign& campaign,
                          const StudySummary& summary) {
  report::Table table{.caption =
                          "Methods over all scenarios. Left: E after over E "
                          "before, medians over the seeds",
                      .columns = {{"method", report::Align::kLeft},
                                  {"scenarios"},
                                  {"closer"},
                                  {"unchanged"},
                                  {"farther"},
                                  {"closest of all"},
                                  {"left of E"},
                                  {"worst scenario"},
                                  {"runs harmed"}}};
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
  return CellTable(
      campaign, summary, rows,
      "Squared distance E, medians over the seeds; harmed: runs with E above "
      "that of the initial model",
      {{"runs",
        [](const Cell& cell) {
          return cell.failed == 0
                     ? FormatInteger(cell.runs)
                     : absl::StrCat(cell.runs, ", ", cell.failed, " failed");
        }},
       MedianColumn("E before", Metric::kInitialE),
       MedianColumn("E", Metric::kE),
       SpanColumn(Metric::kE),
       MedianColumn("E at best λ", Metric::kBestE),
       {"harmed", [](const Cell& cell) { return Percent(cell.harmed); }}});
}

report::Table MeanTable(const Campaign& campaign, const StudySummary& summary,
                        Rows rows) {
  return CellTable(
      campaign, summary, rows,
      "Squared distance E: means, with 95 % intervals by the bootstrap over "
      "the seeds, and extremes",
      {ColumnOf("mean", Metric::kE, MeanText),
       ColumnOf("smallest", Metric::kE,
                [](const auto& E) { return FormatSignificant(E.min); }),
       ColumnOf("largest", Metric::kE,
                [](const auto& E) { return FormatSignificant(E.max); })});
}

report::Table LambdaTable(const Campaign& campaign, const StudySummary& summary,
                          Rows rows) {
  return CellTable(
      campaign, summary, rows, "λ over the seeds: medians, unless said",
      {MedianColumn("best λ", Metric::kBestLambda),
       SpanColumn(Metric::kBestLambda),
       MedianColumn("λ chosen", Metric::kLambdaMin),
       SpanColumn(Metric::kLambdaMin),
       MedianColumn("E / E at best λ", Metric::kRatio),
       ColumnOf("95 %; largest", Metric::kRatio,
                [](const auto& ratio) {
                  return absl::StrCat(FormatSignificant(ratio.quantiles.back()),
                                      "; ", FormatSignificant(ratio.max));
                }),
       {"above 2",
        [](const Cell& cell) { return Percent(cell.above_twice_best); }}});
}

report::Table ElementTable(const Campaign& campaign,
                           const StudySummary& summary, Rows rows) {
  const auto gain_column = [](const char* header, int quantile) {
    return ColumnOf(header, Metric::kGainErrorRms, [=](const auto& gain) {
      return Percent(gain.quantiles[quantile]);
    });
  };
  return CellTable(
      campaign, summary, rows,
      "Errors of first-order fits, RMS over the elements, gains relative to "
      "the plant's: medians over the seeds, unless said",
      {gain_column("gain error", 2), gain_column("95 %", 4),
       MedianColumn("dead-time error", Metric::kDelayErrorRms),
       ColumnOf("95 %", Metric::kDelayErrorRms,
                [](const auto& delay) {
                  return FormatSignificant(delay.quantiles.back());
                }),
       ColumnOf("change proposed", Metric::kProposed,
                [](const auto& proposed) { return Percent(proposed.mean); })});
}

report::Table FailureTable(const StudySummary& summary) {
  report::Table table{
      .caption = "Runs that failed",
      .columns = {{"why (# stands for a number)", report::Align::kLeft},
                  {"runs"}}};
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
