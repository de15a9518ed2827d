#include "apps/lifecycle/results.h"

#include <utility>

#include "apps/lifecycle/figures.h"
#include "apps/lifecycle/outputs.h"
#include "apps/lifecycle/page.h"
#include "apps/report/drawing.h"
#include "mle/base/file.h"

namespace mle::lifecycle {

Results Evaluate(const Request& request, Lives lives) {
  Results results;
  results.valuation = {request.prices, request.hours_per_unit, request.years,
                       request.currency};
  results.summaries = Summarise(request.campaign, lives, results.valuation);
  results.lives = std::move(lives);
  return results;
}

absl::Status WriteResults(const Request& request, const Results& results,
                          const Asked& asked) {
  const Campaign& campaign = request.campaign;
  const auto& [lives, summaries, valuation] = results;
  std::vector<std::pair<std::string, std::string>> files = {
      {"result.json",
       FormatResult(campaign, summaries, valuation, asked.call, asked.options)},
      {"lifecycle.csv", FormatRows(campaign, lives, valuation)}};
  std::vector<report::DrawnFigure> figures;
  if (request.figures) {
    figures = report::DrawFigures(
        MakeFigures(campaign, lives, summaries, valuation), campaign.threads);
  }
  const std::vector<std::string> missing = report::AddPictures(figures, files);
  files.emplace_back("report.html", FormatPage(campaign, summaries, valuation,
                                               figures, asked.run_again));
  return WriteFilesTogether(campaign.folder, files, missing);
}

}  // namespace mle::lifecycle
