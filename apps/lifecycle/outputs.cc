#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/command_line.h"
#include "apps/lifecycle/report.h"
#include "apps/lifecycle/summary.h"
#include "mle/data/csv_rows.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::lifecycle {
namespace {

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

}  // namespace

std::string FormatResult(
    const Campaign& campaign, const std::vector<RateSummary>& summaries,
    const Valuation& valuation, const std::string& command,
    const std::vector<std::pair<std::string, std::string>>& flags) {
  Json json = {{"version", 1},
               {"program", "mle_lifecycle"},
               {"program_version", std::string(Version())},
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

}  // namespace mle::lifecycle
