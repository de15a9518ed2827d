#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/experiment/report.h"
#include "apps/report/drawing.h"
#include "apps/report/table.h"
#include "apps/report/text.h"
#include "mle/base/file.h"

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

namespace {

// Mean and extremes of E.
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

// λ chosen and best.
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

// Gains and dead times.
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

// How often each failure occurred.
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

using report::HtmlPage;

using Figures = std::vector<report::DrawnFigure>;

// Rows of a table before a fold is opened, and behind it.
constexpr std::size_t kRowsOpen = 20;
constexpr std::size_t kRowsFolded = 300;

std::string Counted(std::size_t cells) {
  return FormatInteger(static_cast<std::int64_t>(cells));
}

std::string MostFrequentFailure(const StudySummary& summary) {
  const auto most = std::max_element(
      summary.failures.begin(), summary.failures.end(),
      [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == summary.failures.end() ? "" : most->first;
}

void AddDistances(const Campaign& campaign, const StudySummary& summary,
                  HtmlPage& page) {
  page.AddHeading("Distance from the plant");
  if (TallyMethods(campaign, summary).size() > 1) {
    page.AddTable(MethodTable(campaign, summary));
  }
  const std::size_t cells = summary.cells.size();
  page.AddTable(ErrorTable(campaign, summary, {0, kRowsOpen}));
  if (cells <= kRowsOpen) return;
  page.OpenFold(absl::StrCat("The other ", Counted(cells - kRowsOpen), " of ",
                             Counted(cells), " cells"));
  page.AddTable(ErrorTable(campaign, summary, {kRowsOpen, kRowsFolded}));
  if (cells > kRowsOpen + kRowsFolded) {
    page.AddWarning(absl::StrCat(
        "The tables show the first ", kRowsOpen + kRowsFolded, " of ",
        Counted(cells), " cells; all are in summary.csv."));
  }
  page.CloseFold();
}

void AddFigures(const Figures& figures, HtmlPage& page) {
  if (figures.empty()) return;
  page.AddHeading("Over the seeds");
  AddFigure(figures, "sweep", page);
  AddFigure(figures, "distribution", page);
}

void AddFolded(const char* title, const report::Table& table, HtmlPage& page) {
  page.OpenFold(title);
  page.AddTable(table);
  page.CloseFold();
}

void AddDetails(const Campaign& campaign, const StudySummary& summary,
                HtmlPage& page) {
  const Rows rows = {0, kRowsFolded};
  AddFolded("Means and extremes of E", MeanTable(campaign, summary, rows),
            page);
  AddFolded("Gains and dead times", ElementTable(campaign, summary, rows),
            page);
  AddFolded("λ chosen, and the best in hindsight",
            LambdaTable(campaign, summary, rows), page);
  page.OpenFold("Failures and certificate");
  if (summary.failures.empty()) {
    page.AddParagraph("No run failed.");
  } else {
    page.AddTable(FailureTable(summary));
  }
  page.AddParagraph(absl::StrCat(
      "Relative duality gap of every fit of the exact solvers, at every λ of "
      "the grid, over all runs: at most ",
      report::FormatScientific(summary.max_gap, 2), "."));
  page.CloseFold();
}

std::string FormatPage(const Campaign& campaign, const StudySummary& summary,
                       const Figures& figures,
                       const report::RunAgain& run_again) {
  HtmlPage page(absl::StrCat("Campaign: ", campaign.name));
  page.SetVerdict(VerdictOf(campaign, summary));
  if (summary.failed > 0) {
    page.AddWarning(absl::StrCat(
        FormatInteger(summary.failed), " of ", FormatInteger(summary.runs),
        summary.runs == 1 ? " run" : " runs",
        " failed and is in no other number. Most often: ",
        MostFrequentFailure(summary), "."));
  }
  AddDistances(campaign, summary, page);
  AddFigures(figures, page);
  page.AddHeading("In detail");
  AddDetails(campaign, summary, page);
  page.AddLastFolds({{"runs.csv: every run", "runs.csv"},
                     {"summary.csv: every cell and metric", "summary.csv"},
                     {"summary.json: the same", "summary.json"},
                     {"timings.csv: times of the runs", "timings.csv"},
                     {"campaign.json: the campaign", "campaign.json"}},
                    run_again);
  return page.Render();
}

constexpr std::size_t kRowsPrinted = 40;

}  // namespace

absl::Status WriteOutputs(const std::string& folder, bool figures,
                          const Campaign& campaign, const StudySummary& summary,
                          const report::RunAgain& run_again) {
  std::vector<report::NamedFigure> made;
  if (figures) made = MakeFigures(campaign, summary);
  return report::WriteReport(folder, std::move(made), 0,
                             {{"summary.csv", SummaryCsv(summary, campaign)},
                              {"summary.json", SummaryJson(summary, campaign)}},
                             [&](const Figures& drawn) {
                               return FormatPage(campaign, summary, drawn,
                                                 run_again);
                             });
}

void PrintSummary(const Campaign& campaign, const StudySummary& summary) {
  std::cout << report::RenderText(
                   ErrorTable(campaign, summary, {0, kRowsPrinted}))
            << "\n";
  if (summary.cells.size() > kRowsPrinted) {
    std::cout << "… and " << summary.cells.size() - kRowsPrinted
              << " more cells, in summary.csv\n\n";
  }
  std::cout << VerdictOf(campaign, summary).Text();
}

}  // namespace mle::experiment
