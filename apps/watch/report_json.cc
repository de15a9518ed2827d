// watch.json.

#include "apps/common/command_line.h"
#include "apps/watch/days.h"
#include "apps/watch/page.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

using Json = nlohmann::ordered_json;

Json AlarmsOf(const Report& report) {
  Json alarms = Json::array();
  for (const Alarm& alarm : report.watch->alarms) {
    // Of a model that cannot be read any more nothing has a name.
    if (alarm.output >= report.model.num_outputs()) continue;
    alarms.push_back({{"id", alarm.id},
                      {"day", NameOfDay(alarm.day)},
                      {"output", report.model.outputs()[alarm.output].name},
                      {"text", alarm.text}});
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

}  // namespace

std::string FormatReports(const std::vector<Report>& reports) {
  Json controllers = Json::array();
  for (const Report& report : reports) {
    Json controller = {{"name", report.name},
                       {"status", std::string(NameOf(report.status))},
                       {"health", report.health},
                       {"last_day", nullptr},
                       {"days_used", report.used_days},
                       {"days_cannot_tell", report.unused_days},
                       {"sentence", report.sentence},
                       {"page", PageName(report)}};
    if (report.last_day != 0) {
      controller["last_day"] = NameOfDay(report.last_day);
    }
    controller["elements"] = ElementsOf(report);
    controller["alarms"] = AlarmsOf(report);
    controller["proposals"] = ProposalsOf(report);
    controllers.push_back(std::move(controller));
  }
  return FormatJson({{"version", 1},
                     {"program", "mle_watch"},
                     {"program_version", std::string(Version())},
                     {"controllers", std::move(controllers)}});
}

}  // namespace mle::watch
