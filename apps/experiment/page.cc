#include <algorithm>
#include <cstdint>
#include <iostream>
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

}  // namespace

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

namespace {

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
