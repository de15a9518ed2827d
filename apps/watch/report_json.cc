#include "apps/watch/report_json.h"

#include <cstddef>
#include <utility>

#include "apps/common/command_line.h"
#include "apps/watch/days.h"
#include "apps/watch/page.h"
#include "apps/watch/proposal.h"
#include "apps/watch/source.h"
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
    // Of a model that cannot be read any more nothing has a name.
    if (alarm.output >= report.model.num_outputs()) continue;
    alarms.push_back({{"id", alarm.id},
                      {"day", NameOfDay(alarm.day)},
                      {"output", report.model.outputs()[alarm.output].name},
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

// What lists and single answers have in common.
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
  controller["elements"] = ElementsOf(report);
  controller["alarms"] = AlarmsOf(report);
  controller["proposals"] = ProposalsOf(report);
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
                     {"program_version", std::string(Version())},
                     {"controllers", std::move(controllers)}});
}

std::string FormatControllers(const std::vector<Report>& reports) {
  Json controllers = Json::array();
  for (const Report& report : reports) {
    Json controller = SummaryOf(report);
    controller["id"] = FileNameOf(report.name);
    controller["open_alarms"] = CountOpen(report.watch->alarms);
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
