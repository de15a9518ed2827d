#include "apps/study/outputs.h"

#include <iostream>
#include <utility>
#include <vector>

#include "apps/report/drawing.h"
#include "apps/report/table.h"
#include "apps/study/figures.h"
#include "apps/study/headline.h"
#include "apps/study/page.h"
#include "apps/study/tables.h"
#include "mle/base/file.h"

namespace mle::study {
namespace {

using experiment::Campaign;

constexpr std::size_t kRowsPrinted = 40;

}  // namespace

absl::Status WriteOutputs(const std::string& folder, bool figures,
                          const Campaign& campaign, const StudySummary& summary,
                          const report::RunAgain& run_again) {
  std::vector<report::DrawnFigure> drawn;
  if (figures) drawn = report::DrawFigures(MakeFigures(campaign, summary), 0);
  std::vector<std::pair<std::string, std::string>> files;
  const std::vector<std::string> missing = report::AddPictures(drawn, files);
  files.emplace_back("summary.csv", SummaryCsv(summary, campaign));
  files.emplace_back("summary.json", SummaryJson(summary, campaign));
  files.emplace_back("report.html",
                     FormatPage(campaign, summary, drawn, run_again));
  return WriteFilesTogether(folder, files, missing);
}

void PrintSummary(const Campaign& campaign, const StudySummary& summary) {
  std::cout << report::RenderText(
                   ErrorTable(campaign, summary, {0, kRowsPrinted}))
            << "\n";
  if (summary.cells.size() > kRowsPrinted) {
    std::cout << "… and " << summary.cells.size() - kRowsPrinted
              << " more cells, in summary.csv\n\n";
  }
  const report::Verdict verdict = VerdictOf(campaign, summary);
  std::cout << verdict.headline << ".\n";
  for (const std::string& sentence : verdict.sentences) {
    std::cout << sentence << "\n";
  }
}

}  // namespace mle::study
