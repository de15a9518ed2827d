#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "absl/strings/str_join.h"
#include "apps/watch/outlook.h"
#include "apps/watch/report.h"
#include "apps/watch/source.h"
#include "apps/watch/trial.h"
#include "apps/watch/update.h"
#include "mle/base/version.h"
#include "mle/data/civil_time.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

using Json = nlohmann::ordered_json;

Json AcknowledgementOf(const Alarm& alarm) {
  if (!alarm.acknowledged.has_value()) return nullptr;
  return {{"who", alarm.acknowledged->who},
          {"at", FormatIsoTime(static_cast<double>(alarm.acknowledged->at))},
          {"note", alarm.acknowledged->note}};
}

Json DeliveriesOf(const Alarm& alarm) {
  Json deliveries = Json::array();
  for (const Delivery& delivery : alarm.deliveries) {
    deliveries.push_back(
        {{"channel", std::string(NameOf(delivery.channel))},
         {"delivered", delivery.state == Delivery::State::kSent},
         {"attempts", delivery.attempts},
         {"fault", delivery.fault}});
  }
  return deliveries;
}

Json AlarmsOf(const Report& report) {
  Json alarms = Json::array();
  for (const Alarm& alarm : report.watch->alarms) {
    // A model that cannot be read any more has no names of outputs.
    if (alarm.output >= report.model.num_outputs()) continue;
    alarms.push_back(
        {{"id", alarm.id},
         {"kind", std::string(NameOf(alarm.kind))},
         {"day", NameOfDay(alarm.day)},
         {"output",
          alarm.output < 0 ? "" : report.model.outputs()[alarm.output].name},
         {"text", alarm.text},
         {"deliveries", DeliveriesOf(alarm)},
         {"acknowledged", AcknowledgementOf(alarm)}});
  }
  return alarms;
}

Json ElementsOf(const Report& report) {
  Json elements = Json::array();
  for (const ElementHealth& element : report.elements) {
    elements.push_back({{"output", report.model.outputs()[element.output].name},
                        {"input", report.model.inputs()[element.input].name},
                        {"health", element.health},
                        {"log_evidence", element.log_evidence}});
  }
  return elements;
}

Json EstimateOf(const CourseEstimate& estimate) {
  return {
      {"mean", estimate.mean}, {"low", estimate.low}, {"high", estimate.high}};
}

Json TrendOf(const Report& report, int output) {
  const ProcessModel& model = report.model;
  const OutputTrend& trend =
      report.outlook.trends[static_cast<std::size_t>(output)];
  const AgeingCourse& course = trend.course;
  Json json = {{"told", std::string(NameOf(course.state))},
               {"text", TrendText(model, output, trend)}};
  if (course.state == AgeingCourse::State::kTooShort) return json;
  json["input"] = model.inputs()[trend.input].name;
  json["parameter"] = ParameterKey(course.parameter);
  json["probability_changed"] = course.changed;
  json["probability"] = course.probability;
  json["change"] = EstimateOf(course.change);
  json["change_per_month"] = EstimateOf(course.rate);
  return json;
}

Json OutputsOf(const Report& report) {
  Json outputs = Json::array();
  for (std::size_t i = 0; i < report.output_health.size(); ++i) {
    Json output = {{"output", report.model.outputs()[i].name},
                   {"health", report.output_health[i]},
                   {"trend", nullptr}};
    if (i < report.outlook.trends.size()) {
      output["trend"] = TrendOf(report, static_cast<int>(i));
    }
    outputs.push_back(std::move(output));
  }
  return outputs;
}

Json NextChangeOf(const Report& report) {
  if (!report.outlook.next.has_value()) return nullptr;
  const ProcessModel& model = report.model;
  const ProposedChange& proposed = *report.outlook.next;
  const NextChange& next = proposed.next;
  Json json = {{"state", std::string(NameOf(next.state))},
               {"text", NextChangeText(model, proposed)}};
  if (next.state == NextChange::State::kEnough ||
      next.state == NextChange::State::kNamed) {
    return json;
  }
  constexpr const char* kQuestions[] = {"likely", "unseen", "baseline"};
  json["question"] = kQuestions[static_cast<int>(next.question)];
  json["output"] = model.outputs()[next.output].name;
  json["input"] = model.inputs()[proposed.input].name;
  json["parameter"] = ParameterKey(next.parameter);
  json["assumed_change"] = next.change;
  json["log_evidence"] = next.log_evidence;
  json["log_evidence_of_alarm"] = next.log_alarm;
  if (next.state == NextChange::State::kNoneTells) return json;
  json["set_point"] = model.outputs()[next.set_point].name;
  json["size"] = next.size;
  json["changes"] = next.changes;
  json["log_evidence_expected"] = next.log_expected;
  return json;
}

// An infinite upper end becomes null: JSON has no number for it.
Json MoneyOf(const CourseEstimate& cost) {
  Json json = EstimateOf(cost);
  if (!std::isfinite(cost.high)) json["high"] = nullptr;
  return json;
}

Json DayOrNull(const std::optional<int>& day) {
  return day.has_value() ? Json(NameOfDay(*day)) : Json();
}

Json CostOf(const Report& report) {
  const AgeingCost& cost = report.cost;
  Json json = {{"told", std::string(NameOf(cost.state))},
               {"text", CostText(report.model, cost)}};
  if (cost.state != AgeingCost::State::kTold) return json;
  json["currency"] = cost.currency;
  json["per_month"] = MoneyOf(cost.points.front().cost);
  Json& forecast = json["forecast"] = Json::array();
  for (const CostPoint& point : cost.points) {
    Json later = MoneyOf(point.cost);
    later["day"] = NameOfDay(point.day);
    forecast.push_back(std::move(later));
  }
  Json& not_counted = json["not_counted"] = Json::array();
  for (const int output : cost.not_counted) {
    not_counted.push_back(report.model.outputs()[output].name);
  }
  json["update"] = {{"text", UpdateText(cost)},
                    {"cost", cost.update},
                    {"days_between_updates", cost.days_between_updates},
                    {"pays_now", cost.pays_now()},
                    {"pays", DayOrNull(cost.pays)},
                    {"earliest", DayOrNull(cost.earliest)},
                    {"latest", DayOrNull(cost.latest)}};
  return json;
}

Json ProposalsOf(const Report& report) {
  Json proposals = Json::array();
  for (const Proposal& proposal : report.watch->proposals) {
    proposals.push_back({{"day", NameOfDay(proposal.day)},
                         {"folder", proposal.folder},
                         {"decision", proposal.decision},
                         {"conclusion", proposal.conclusion}});
  }
  return proposals;
}

Json TrialOf(const Report& report) {
  if (!report.trial.has_value()) return nullptr;
  const TrialReport& trial = *report.trial;
  const TrialVerdict& verdict = trial.verdict;
  Json json = {{"day", NameOfDay(trial.day)},
               {"last_day", NameOfDay(trial.last_day)},
               {"advice", std::string(NameOf(verdict.advice))},
               {"text", absl::StrJoin(TrialSentences(trial), " ")},
               {"ended", trial.ended},
               {"fault", trial.fault},
               {"level", trial.level},
               {"changes", verdict.changes},
               {"responses", verdict.responses},
               {"responses_not_judged", verdict.not_judged},
               {"left_share", verdict.left_share},
               {"loss_ratio", trial.loss_ratio},
               {"adopted", nullptr}};
  if (trial.adopted.has_value()) {
    json["adopted"] = {{"day", NameOfDay(trial.adopted_day)},
                       {"who", trial.adopted->who},
                       {"at", nullptr},
                       {"note", trial.adopted->note}};
    if (trial.adopted->at > 0) {
      json["adopted"]["at"] =
          FormatIsoTime(static_cast<double>(trial.adopted->at));
    }
  }
  Json& history = json["history"] = Json::array();
  for (const TrialReport::Point& point : trial.history) {
    history.push_back({{"time", FormatIsoTime(point.day * kSecondsOfDay)},
                       {"log10_evidence_for", point.log10_for},
                       {"log10_evidence_against", point.log10_against}});
  }
  return json;
}

// The fields that lists and single answers share.
Json SummaryOf(const Report& report) {
  Json summary = {{"name", report.name},
                  {"status", std::string(NameOf(report.status))},
                  {"health", report.health},
                  {"last_day", nullptr},
                  {"days_used", report.used_days},
                  {"days_cannot_tell", report.unused_days},
                  {"sentence", report.sentence},
                  {"page", PageName(report)}};
  if (report.last_day != 0) summary["last_day"] = NameOfDay(report.last_day);
  return summary;
}

Json ControllerOf(const Report& report) {
  Json controller = SummaryOf(report);
  controller["outputs"] = OutputsOf(report);
  controller["elements"] = ElementsOf(report);
  controller["ageing_cost"] = CostOf(report);
  controller["next_change"] = NextChangeOf(report);
  controller["alarms"] = AlarmsOf(report);
  controller["proposals"] = ProposalsOf(report);
  controller["trial"] = TrialOf(report);
  return controller;
}

}  // namespace

std::string FormatReports(const std::vector<Report>& reports) {
  Json controllers = Json::array();
  for (const Report& report : reports) {
    controllers.push_back(ControllerOf(report));
  }
  return FormatJson({{"version", 1},
                     {"program", "mle_watch"},
                     {"program_version", std::string(LibraryVersion())},
                     {"controllers", std::move(controllers)}});
}

std::string FormatControllers(const std::vector<Report>& reports) {
  Json controllers = Json::array();
  for (const Report& report : reports) {
    Json controller = SummaryOf(report);
    controller["id"] = FileNameOf(report.name);
    controller["open_alarms"] = CountOpen(report.watch->alarms);
    controller["ageing_cost_per_month"] = nullptr;
    if (report.cost.state == AgeingCost::State::kTold) {
      controller["ageing_cost_per_month"] =
          report.cost.points.front().cost.mean;
    }
    controller["update_pays"] = DayOrNull(report.cost.pays);
    controller["trial"] = nullptr;
    if (report.trial.has_value() && !report.trial->IsOver()) {
      controller["trial"] = std::string(NameOf(report.trial->verdict.advice));
    }
    controllers.push_back(std::move(controller));
  }
  return FormatJson({{"controllers", std::move(controllers)}});
}

std::string FormatController(const Report& report) {
  Json controller = ControllerOf(report);
  controller["id"] = FileNameOf(report.name);
  return FormatJson(controller);
}

std::string FormatHistory(const Report& report, int from, int to) {
  Json points = Json::array();
  for (std::size_t i = 0; i < report.trends.size(); ++i) {
    for (const HealthPoint& point : report.trends[i]) {
      if (point.day < from || point.day > to) continue;
      points.push_back(
          {{"time", FormatIsoTime((point.day + 1) * kSecondsOfDay)},
           {"output", report.model.outputs()[i].name},
           {"health", point.health}});
    }
  }
  return FormatJson({{"controller", report.name}, {"history", points}});
}

std::string FormatAlarms(const std::vector<Report>& reports, bool only_open) {
  Json alarms = Json::array();
  for (const Report& report : reports) {
    for (Json& alarm : AlarmsOf(report)) {
      if (only_open && !alarm["acknowledged"].is_null()) continue;
      alarm["controller"] = report.name;
      alarm["page"] = PageName(report);
      alarms.push_back(std::move(alarm));
    }
  }
  return FormatJson({{"alarms", std::move(alarms)}});
}

}  // namespace mle::watch
