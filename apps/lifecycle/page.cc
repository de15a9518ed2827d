#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/lifecycle/report.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/drawing.h"
#include "mle/base/file.h"
#include "mle/base/version.h"
#include "mle/data/csv_rows.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::lifecycle {
namespace {

using report::HtmlPage;

using Figures = std::vector<report::DrawnFigure>;

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
  page.AddWarnings(warnings);
}

// That the old model may cost less than the plant's own.
void AddBelowTheReference(const RateSummary& rate, HtmlPage& page) {
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
  AddBelowTheReference(rate, page);
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
    AddBelowTheReference(rate, page);
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
  page.AddLastFolds({{"result.json: every number of this page", "result.json"},
                     {"lifecycle.csv: every set-point change of every life",
                      "lifecycle.csv"}},
                    run_again);
  return page.Render();
}

using Json = nlohmann::ordered_json;

Json ToJson(const MeanOfSeeds& value) {
  return {{"mean", value.mean}, {"half_width_95", value.half_width}};
}

Json ToJson(const PolicySummary& policy) {
  return {{"policy", policy.policy.name},
          {"cost_per_year", ToJson(policy.cost)},
          {"parts_per_year",
           {{"product", policy.parts.product},
            {"violation", policy.parts.violation},
            {"movement", policy.parts.movement},
            {"test_hours", policy.parts.test_hours},
            {"engineering", policy.parts.engineering}}},
          {"saving_per_year", ToJson(policy.saving)},
          {"excess_over_perfect_per_year", ToJson(policy.excess)},
          {"over_cheapest_per_year", ToJson(policy.over_cheapest)},
          {"told_apart_from_cheapest", ToldApart(policy.over_cheapest)},
          {"share_saved", policy.share_saved},
          {"updates", policy.updates},
          {"refusals", policy.refusals},
          {"reverted", policy.reverted},
          {"unchanged", policy.unchanged},
          {"step_tests", policy.tests},
          {"step_test_hours", policy.test_hours},
          {"distance", policy.distance},
          {"gain_error", policy.gain_error},
          {"delay_error", policy.delay_error},
          {"ran_away", policy.ran_away}};
}

Json ToJson(const BreakEven& break_even) {
  if (break_even.test.empty()) return nullptr;
  return {{"step_test_policy", break_even.test},
          {"correction_policy", break_even.correction},
          {"price_of_test_hour", break_even.price}};
}

// ",value", empty where there is none.
void Append(std::string& csv, double value) {
  csv += ',';
  if (std::isfinite(value)) absl::StrAppendFormat(&csv, "%.12g", value);
}

void AppendRow(const ChangeRow& row, const Campaign& campaign,
               const Valuation& valuation, std::string& csv) {
  const SetPointEvent& event = row.event;
  Append(csv, event.time * valuation.hours_per_unit / 24.0);
  const bool change = event.output >= 0;
  absl::StrAppend(
      &csv, ",",
      change ? QuoteCsvField(campaign.plant.outputs()[event.output].name) : "");
  Append(csv, change ? event.before[event.output] : NAN);
  Append(csv, change ? event.after[event.output] : NAN);
  Append(csv, row.error.distance);
  Append(csv, row.error.gain);
  Append(csv, row.error.delay);
  const control::OperationSums total = row.Total();
  const double hours = valuation.hours_per_unit;
  Append(csv, hours * row.quiet.squared_error.sum());
  Append(csv, hours * row.transient.squared_error.sum());
  Append(csv, hours * row.test.squared_error.sum());
  Append(csv, hours * row.watch.squared_error.sum());
  Append(csv, hours * total.absolute_error.sum());
  Append(csv, hours * total.violation.sum());
  Append(csv, total.movement.sum());
  Append(csv, hours * row.test.time);
  const control::Cost cost = CostOf(row, valuation.prices, hours);
  Append(csv, cost.total());
  Append(csv, row.index);
  absl::StrAppend(&csv, ",", std::string(NameOf(row.outcome)));
  Append(csv, row.held_out_gain);
  absl::StrAppend(&csv, ",", QuoteCsvField(row.reason), "\n");
}

std::string FormatResult(
    const Campaign& campaign, const std::vector<RateSummary>& summaries,
    const Valuation& valuation, const std::string& command,
    const std::vector<std::pair<std::string, std::string>>& flags) {
  Json json = {{"version", 1},
               {"program", "mle_lifecycle"},
               {"program_version", std::string(LibraryVersion())},
               {"command", command}};
  Json flag_values = Json::object();
  for (const auto& [name, value] : flags) flag_values[name] = value;
  json["flags"] = std::move(flag_values);
  json["years"] = valuation.years;
  json["currency"] = valuation.currency;
  json["seeds"] = campaign.seeds;
  Json rates = Json::array();
  for (const RateSummary& rate : summaries) {
    Json policies = Json::array();
    for (const PolicySummary& policy : rate.policies) {
      policies.push_back(ToJson(policy));
    }
    const PolicySummary* cheapest = rate.Cheapest();
    rates.push_back(
        {{"ageing_rate", rate.rate},
         {"cheapest", cheapest ? Json(cheapest->policy.name) : Json(nullptr)},
         {"break_even", ToJson(rate.break_even)},
         {"policies", std::move(policies)}});
  }
  json["rates"] = std::move(rates);
  return FormatJson(json);
}

std::string FormatRows(const Campaign& campaign, const Lives& lives,
                       const Valuation& valuation) {
  std::string csv =
      "ageing_rate,seed,policy,day,output,setpoint_before,setpoint_after,"
      "distance,gain_error,delay_error,squared_error_quiet,"
      "squared_error_transient,squared_error_test,squared_error_watch,absolute_"
      "error,violation,"
      "movement,test_hours,cost,performance_index,outcome,held_out_gain,"
      "reason\n";
  for (std::size_t r = 0; r < campaign.rates.size(); ++r) {
    for (std::size_t s = 0; s < campaign.seeds.size(); ++s) {
      for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
        for (const ChangeRow& row : lives[r][s][p].rows) {
          absl::StrAppendFormat(&csv, "%.12g,%d,%s", campaign.rates[r],
                                campaign.seeds[s], campaign.policies[p].name);
          AppendRow(row, campaign, valuation, csv);
        }
      }
    }
  }
  return csv;
}

}  // namespace

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
  std::vector<report::NamedFigure> figures;
  if (request.figures) {
    figures = MakeFigures(campaign, lives, summaries, valuation);
  }
  return report::WriteReport(
      campaign.folder, std::move(figures), campaign.threads,
      {{"result.json", FormatResult(campaign, summaries, valuation, asked.call,
                                    asked.options)},
       {"lifecycle.csv", FormatRows(campaign, lives, valuation)}},
      [&](const Figures& drawn) {
        return FormatPage(campaign, results.summaries, results.valuation, drawn,
                          asked.run_again);
      });
}

}  // namespace mle::lifecycle
