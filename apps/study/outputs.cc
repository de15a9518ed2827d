#include "apps/study/outputs.h"

#include <cmath>
#include <iostream>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/report/drawing.h"
#include "apps/report/number.h"
#include "apps/study/figures.h"
#include "apps/study/labels.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

using experiment::Campaign;
using experiment::Distribution;
using experiment::Metric;

using report::FormatInteger;
using report::FormatScientific;
using report::FormatSignificant;

constexpr int kRowsOnPage = 300;
constexpr int kRowsPrinted = 40;

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

report::Table CellTable(const Campaign& campaign, const StudySummary& summary,
                        std::vector<report::Column> columns, int most,
                        std::vector<std::string> (*values)(const Cell&)) {
  report::Table table;
  table.columns = {{"scenario", report::Align::kLeft},
                   {"method", report::Align::kLeft}};
  for (report::Column& column : columns) {
    table.columns.push_back(std::move(column));
  }
  for (const Cell& cell : summary.cells) {
    if (static_cast<int>(table.rows.size()) == most) break;
    std::vector<std::string> row = {
        ScenarioLabel(campaign, cell.at.scenario),
        MethodLabel(campaign, campaign.methods[cell.at.method])};
    for (std::string& value : values(cell)) row.push_back(std::move(value));
    table.AddRow(std::move(row));
  }
  return table;
}

report::Table LambdaTable(const Campaign& campaign,
                          const StudySummary& summary) {
  report::Table table = CellTable(
      campaign, summary,
      {{"best λ"},
       {"5 … 95 %"},
       {"λ chosen"},
       {"5 … 95 %"},
       {"E / E at best λ"},
       {"95 %"},
       {"largest"},
       {"above 2"}},
      kRowsOnPage, [](const Cell& cell) -> std::vector<std::string> {
        const Distribution& ratio = cell[Metric::kRatio];
        return {
            MedianText(cell[Metric::kBestLambda]),
            SpanText(cell[Metric::kBestLambda]),
            MedianText(cell[Metric::kLambdaMin]),
            SpanText(cell[Metric::kLambdaMin]),
            MedianText(ratio),
            ratio.count == 0 ? "–" : FormatSignificant(ratio.quantiles.back()),
            ratio.count == 0 ? "–" : FormatSignificant(ratio.max),
            Percent(cell.above_twice_best)};
      });
  table.caption = "λ over the seeds: medians, unless said";
  return table;
}

report::Table ElementTable(const Campaign& campaign,
                           const StudySummary& summary) {
  report::Table table = CellTable(
      campaign, summary,
      {{"gain error"},
       {"95 %"},
       {"dead-time error"},
       {"95 %"},
       {"change proposed"}},
      kRowsOnPage, [](const Cell& cell) -> std::vector<std::string> {
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

std::vector<std::string> Findings(const Campaign& campaign,
                                  const StudySummary& summary) {
  std::vector<std::string> sentences = {absl::StrCat(
      FormatInteger(summary.runs),
      " runs: ", FormatInteger(static_cast<std::int64_t>(summary.cells.size())),
      " cells of the grid with ",
      FormatInteger(static_cast<std::int64_t>(campaign.seeds.size())),
      " seeds each. ",
      summary.failed == 0
          ? "None failed."
          : absl::StrCat(FormatInteger(summary.failed), " failed."))};
  constexpr std::size_t kMost = 4;
  for (const Cell& cell : summary.cells) {
    if (sentences.size() > kMost) break;
    const Distribution& E = cell[Metric::kE];
    if (E.count == 0 ||
        !campaign.methods[cell.at.method].estimator.has_value()) {
      continue;
    }
    sentences.push_back(absl::StrCat(
        ScenarioLabel(campaign, cell.at.scenario), ", ",
        MethodLabel(campaign, campaign.methods[cell.at.method]), ": E from ",
        FormatSignificant(cell[Metric::kInitialE].median()), " to ",
        FormatSignificant(E.median()), " (medians; nine of ten between ",
        FormatSignificant(E.quantiles.front()), " and ",
        FormatSignificant(E.quantiles.back()), ")."));
  }
  return sentences;
}

std::string FormatPage(const Campaign& campaign, const StudySummary& summary,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again) {
  report::HtmlPage page(absl::StrCat("Campaign: ", campaign.name));
  page.AddSummary(Findings(campaign, summary));
  page.AddHeading("Distance from the plant");
  page.AddParagraph(
      "E is the sum of the squared differences of the step responses over all "
      "input–output pairs and samples. Means have 95 % intervals by the "
      "bootstrap over the seeds. Harmed: E is above that of the initial "
      "model.");
  page.AddTable(ErrorTable(campaign, summary, kRowsOnPage));
  if (static_cast<int>(summary.cells.size()) > kRowsOnPage) {
    page.AddWarning(absl::StrCat(
        "The tables show the first ", kRowsOnPage, " of ",
        FormatInteger(static_cast<std::int64_t>(summary.cells.size())),
        " cells; all are in summary.csv."));
  }
  if (!figures.empty()) page.AddHeading("Figures");
  for (const report::DrawnFigure& figure : figures) {
    report::AddFigure(figures, figure.named.name, page);
  }
  page.AddHeading("λ, gains and dead times");
  page.AddTable(LambdaTable(campaign, summary));
  page.AddTable(ElementTable(campaign, summary));
  page.AddHeading("Failures and certificate");
  if (summary.failures.empty()) {
    page.AddParagraph("No run failed.");
  } else {
    page.AddTable(FailureTable(summary));
  }
  page.AddParagraph(absl::StrCat(
      "Relative duality gap of every fit of the exact solvers, at every λ of "
      "the grid, over all runs: at most ",
      FormatScientific(summary.max_gap, 2), "."));
  page.AddFiles({{"runs.csv", "runs.csv"},
                 {"summary.csv", "summary.csv"},
                 {"summary.json", "summary.json"},
                 {"timings.csv", "timings.csv"},
                 {"campaign.json", "campaign.json"}});
  page.AddRunAgain(run_again);
  return page.Render();
}

}  // namespace

report::Table ErrorTable(const Campaign& campaign, const StudySummary& summary,
                         int most) {
  report::Table table = CellTable(
      campaign, summary,
      {{"runs"},
       {"E before"},
       {"E"},
       {"5 … 95 %"},
       {"largest"},
       {"mean"},
       {"E at best λ"},
       {"harmed"}},
      most, [](const Cell& cell) -> std::vector<std::string> {
        const Distribution& E = cell[Metric::kE];
        return {cell.failed == 0
                    ? FormatInteger(cell.runs)
                    : absl::StrCat(cell.runs, ", ", cell.failed, " failed"),
                MedianText(cell[Metric::kInitialE]),
                MedianText(E),
                SpanText(E),
                E.count == 0 ? "–" : FormatSignificant(E.max),
                MeanText(E),
                MedianText(cell[Metric::kBestE]),
                Percent(cell.harmed)};
      });
  table.caption = "Squared distance E over the seeds: medians, unless said";
  return table;
}

absl::Status WriteOutputs(const std::string& folder, bool figures,
                          const Campaign& campaign, const StudySummary& summary,
                          const report::RunAgain& run_again) {
  std::vector<report::DrawnFigure> drawn;
  if (figures) drawn = report::DrawFigures(MakeFigures(campaign, summary), 0);
  std::vector<std::pair<std::string, std::string>> files;
  report::AddPictures(drawn, files);
  files.emplace_back("summary.csv", SummaryCsv(summary, campaign));
  files.emplace_back("summary.json", SummaryJson(summary, campaign));
  files.emplace_back("report.html",
                     FormatPage(campaign, summary, drawn, run_again));
  return WriteFilesTogether(folder, files);
}

void PrintSummary(const Campaign& campaign, const StudySummary& summary) {
  std::cout << report::RenderText(ErrorTable(campaign, summary, kRowsPrinted))
            << "\n";
  if (static_cast<int>(summary.cells.size()) > kRowsPrinted) {
    std::cout << "… and " << summary.cells.size() - kRowsPrinted
              << " more cells, in summary.csv\n\n";
  }
}

}  // namespace mle::study
