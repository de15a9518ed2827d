#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/report.h"
#include "apps/report/drawing.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::lifecycle {
namespace {

using report::HtmlPage;

using Figures = std::vector<report::DrawnFigure>;

// More of them are folded.
constexpr std::size_t kMostWarnings = 3;

void AddWarnings(const std::vector<RateSummary>& summaries, std::size_t lives,
                 HtmlPage& page) {
  std::vector<std::string> warnings;
  for (const RateSummary& rate : summaries) {
    for (const PolicySummary& policy : rate.policies) {
      if (policy.ran_away == 0) continue;
      warnings.push_back(absl::StrCat(
          "Ageing rate ", rate.rate, ", ", ShortName(policy.policy),
          ": the loop diverged in ", policy.ran_away, " of ", lives,
          lives == 1 ? " life" : " lives", "; its cost is not known."));
    }
  }
  const bool many = warnings.size() > kMostWarnings;
  if (many) page.OpenFold(absl::StrCat(warnings.size(), " warnings"));
  for (const std::string& warning : warnings) page.AddWarning(warning);
  if (many) page.CloseFold();
}

// That the old model may cost less than the plant's own.
void AddBelowTheFloor(const RateSummary& rate, HtmlPage& page) {
  const bool below = std::any_of(
      rate.policies.begin(), rate.policies.end(), [](const PolicySummary& p) {
        return p.excess.mean < 0.0 && ToldApart(p.excess);
      });
  if (!below) return;
  page.AddParagraph(
      "A policy costs less than the perfect model here. Where gains have "
      "fallen, an old model makes the controller calmer, and less measurement "
      "noise reaches the product.");
}

void AddCosts(const RateSummary& rate, std::size_t lives,
              const std::string& currency, const Figures& figures,
              HtmlPage& page) {
  page.AddHeading("What each policy costs");
  page.AddTable(ComparisonTable(rate, lives, currency));
  AddBelowTheFloor(rate, page);
  AddFigure(figures, "policy_costs", page);
  page.OpenFold("What a year's cost is made of");
  page.AddParagraph(
      "Deviations from the set points and beyond limits are those of the true "
      "outputs, without measurement noise, including the quiet times between "
      "changes. The price of the hours of a step test is added to the cost of "
      "the product made in them.");
  page.AddTable(CostTable(rate, currency));
  page.CloseFold();
}

void AddPolicies(const Campaign& campaign, HtmlPage& page) {
  page.AddHeading("What each policy does");
  std::vector<std::pair<std::string, std::string>> terms;
  for (const Policy& policy : campaign.policies) {
    terms.emplace_back(
        ShortName(policy),
        absl::StrCat(Description(policy), " (--policies=", policy.name, ")"));
  }
  page.AddTerms(terms);
}

void AddRates(const std::vector<RateSummary>& summaries, std::size_t lives,
              const std::string& currency, HtmlPage& page) {
  if (summaries.size() < 2) return;
  page.AddHeading("At other rates of ageing");
  if (summaries.front().Find(Policy::Kind::kNever) != nullptr &&
      summaries.front().policies.size() > 1) {
    page.AddTable(SavingTable(summaries, currency));
  }
  for (const RateSummary& rate : summaries) {
    if (&rate == &NominalRate(summaries)) continue;
    page.OpenFold(absl::StrCat("Costs at ageing rate ", rate.rate));
    page.AddTable(ComparisonTable(rate, lives, currency));
    AddBelowTheFloor(rate, page);
    page.AddTable(CostTable(rate, currency));
    page.CloseFold();
  }
}

void AddCourse(const std::vector<RateSummary>& summaries,
               const Figures& figures, HtmlPage& page) {
  page.AddHeading("Over the years");
  AddFigure(figures, "over_time", page);
  page.OpenFold("Updates, refusals, step tests and errors of the models");
  page.AddParagraph(
      "Updates, refusals and step tests are counted over a whole life. Mean "
      "errors are of the model in use at each set-point change: squared "
      "distance E of its step responses from the plant's, its largest relative "
      "gain error and its largest dead-time error.");
  for (const RateSummary& rate : summaries) page.AddTable(ActivityTable(rate));
  page.CloseFold();
}

}  // namespace

std::string FormatPage(const Campaign& campaign,
                       const std::vector<RateSummary>& summaries,
                       const Valuation& valuation, const Figures& figures,
                       const report::RunAgain& run_again) {
  HtmlPage page(absl::StrCat("The life of a model: ", campaign.model.name()));
  const std::size_t lives = campaign.seeds.size();
  page.SetVerdict(VerdictOf(campaign, summaries, valuation));
  AddWarnings(summaries, lives, page);
  AddCosts(NominalRate(summaries), lives, valuation.currency, figures, page);
  AddPolicies(campaign, page);
  AddRates(summaries, lives, valuation.currency, page);
  AddCourse(summaries, figures, page);
  page.OpenFold("Files");
  page.AddFiles({{"result.json: every number of this page", "result.json"},
                 {"lifecycle.csv: every set-point change of every life",
                  "lifecycle.csv"}});
  page.CloseFold();
  page.OpenFold("Run it again");
  page.AddRunAgain(run_again);
  page.CloseFold();
  return page.Render();
}

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
