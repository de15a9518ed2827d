#include "apps/watch/page.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "apps/report/html.h"
#include "apps/report/number.h"
#include "apps/report/table.h"
#include "apps/watch/days.h"
#include "apps/watch/page_text.h"
#include "apps/watch/trend_page.h"

namespace mle::watch {
namespace {

using report::Align;
using report::Table;

constexpr int kShownDays = 30;
report::Badge BadgeOf(Status status) {
  return status == Status::kHealthy ? report::Badge::kGood
         : status == Status::kAged  ? report::Badge::kChanged
                                    : report::Badge::kUnknown;
}

Table ElementTable(const Report& report) {
  Table table{.caption = "Health of the elements",
              .columns = {{"element", Align::kLeft},
                          {"health"},
                          {"evidence, ln E"},
                          {"in words", Align::kLeft}}};
  for (const ElementHealth& element : report.elements) {
    table.AddRow({PairName(report.model, element.output, element.input),
                  report::FormatFixed(element.health, 3),
                  report::FormatFixed(element.log_evidence, 1),
                  element.health <= 0.5   ? "has aged, whatever the others did"
                  : element.health <= 0.9 ? "some evidence of ageing"
                                          : "no evidence of ageing"});
  }
  return table;
}

void AddAcknowledging(const Alarm& alarm, report::HtmlPage& page) {
  using Kind = report::Form::Field::Kind;
  page.OpenFold(absl::StrCat("Acknowledge the alarm of ", NameOfDay(alarm.day),
                             " (", ShortId(alarm), ")"));
  page.AddForm(
      {.action = kAcknowledgePath,
       .submit = "Acknowledge",
       .fields = {{.name = "alarm", .kind = Kind::kHidden, .value = alarm.id},
                  {.name = "who",
                   .label = "Your name",
                   .most_characters = 100,
                   .required = true},
                  {.name = "note", .label = "Note", .most_characters = 500},
                  {.name = "token",
                   .label = "Token",
                   .kind = Kind::kPassword,
                   .required = true}}});
  page.CloseFold();
}

void AddAlarmRows(const Report& report, bool can_acknowledge,
                  report::HtmlPage& page) {
  page.AddHeading("Alarms");
  if (report.watch->alarms.empty()) {
    page.AddParagraph("None was raised.");
    return;
  }
  Table table{.caption = "Alarms",
              .columns = {{"day"},
                          {"what", Align::kLeft},
                          {"acknowledged", Align::kLeft},
                          {"handed on to", Align::kLeft},
                          {"id", Align::kLeft}},
              .stacked = true};
  for (const Alarm& alarm : report.watch->alarms) {
    table.AddRow({NameOfDay(alarm.day), alarm.text, AcknowledgementText(alarm),
                  DeliveryText(alarm), ShortId(alarm)});
  }
  page.AddTable(table);
  for (const Alarm& alarm : report.watch->alarms) {
    if (can_acknowledge && !alarm.acknowledged.has_value()) {
      AddAcknowledging(alarm, page);
    }
  }
}

void AddProposals(const Report& report, const std::string& folder,
                  report::HtmlPage& page) {
  if (report.watch->proposals.empty()) return;
  page.AddHeading("Corrections");
  page.AddParagraph(
      "Run on the records since the change most likely began, of 60 days at "
      "most. Nothing is written to a "
      "controller: whether a correction is taken is for an engineer to say.");
  for (const Proposal& proposal : report.watch->proposals) {
    page.AddParagraph(absl::StrCat(NameOfDay(proposal.day), ": ",
                                   proposal.decision, ". ",
                                   proposal.conclusion));
    const std::filesystem::path made =
        std::filesystem::path(proposal.folder) / "report.html";
    std::error_code error;
    if (std::filesystem::exists(made, error)) {
      page.AddFiles({{absl::StrCat("Report of ", NameOfDay(proposal.day)),
                      made.lexically_proximate(folder).generic_string()}});
    }
  }
}

void AddNextChange(const Report& report, report::HtmlPage& page) {
  if (!report.outlook.next.has_value()) return;
  page.AddHeading("Next change of a set point");
  if (report.status == Status::kCannotTell) {
    page.AddParagraph(
        "First what makes days useless has to be mended (below); then:");
  }
  page.AddParagraph(NextChangeText(report.model, *report.outlook.next));
}

void AddCost(const Report& report, report::HtmlPage& page) {
  const AgeingCost& cost = report.cost;
  const std::string text = CostText(report.model, cost);
  if (text.empty()) return;
  page.AddHeading("Costs of ageing");
  page.AddParagraph(text);
  if (cost.state != AgeingCost::State::kTold) return;
  page.AddParagraph(UpdateText(cost));
  if (cost.points.front().cost.mean == cost.points.back().cost.mean) {
    return;  // What stands still costs the same later.
  }
  Table table{
      .caption = absl::StrCat("Costs of ageing, if it goes on, a month",
                              cost.currency.empty() ? "" : ", ", cost.currency),
      .columns = {{"day"}, {"expected"}, {"interval of 95 %"}}};
  for (const CostPoint& point : cost.points) {
    table.AddRow({NameOfDay(point.day), report::FormatMoney(point.cost.mean),
                  CostInterval(point.cost)});
  }
  page.AddTable(table);
}

void AddUnusedDays(const Report& report, report::HtmlPage& page) {
  Table table{.caption = "The last days of which it cannot be told",
              .columns = {{"day", Align::kLeft}, {"because", Align::kLeft}}};
  for (auto day = report.watch->days.rbegin();
       day != report.watch->days.rend() &&
       static_cast<int>(table.rows.size()) < kShownDays;
       ++day) {
    if (day->second.state != BatchState::kCannotTell) continue;
    table.AddRow({NameOfDay(day->first), day->second.reason});
  }
  if (table.rows.empty()) return;
  page.AddHeading("Days that say nothing");
  page.AddTable(table);
}

}  // namespace

std::string FormatControllerPage(const Report& report,
                                 const std::string& folder,
                                 bool can_acknowledge) {
  report::HtmlPage page(absl::StrCat("Controller ", report.name));
  page.SetVerdict(
      {.badge = BadgeOf(report.status),
       .label = std::string(WordsFor(report.status)),
       .headline = absl::StrCat(report.name, ": health ", HealthText(report)),
       .sentences = {report.sentence}});
  page.AddFiles(
      {{"All controllers", kOverviewPage}, {"All alarms", kAlarmsPage}});
  if (!report.watch->news.empty() && report.sentence != report.watch->news) {
    page.AddWarning(report.watch->news);
  }
  AddAlarmRows(report, can_acknowledge, page);
  AddProposals(report, folder, page);
  AddCost(report, page);
  AddNextChange(report, page);
  if (!report.elements.empty()) {
    page.AddHeading("Elements");
    page.AddParagraph(kMeaning);
    page.AddTable(ElementTable(report));
  }
  AddTrend(report, page);
  AddUnusedDays(report, page);
  page.AddHeading("Records");
  page.AddTerms(
      {{"Last day", LastDayOf(report)},
       {"Days with changes that were used", absl::StrCat(report.used_days)},
       {"Days of which it cannot be told", absl::StrCat(report.unused_days)}});
  return page.Render();
}

}  // namespace mle::watch
