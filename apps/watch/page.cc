#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/report/html.h"
#include "apps/report/table.h"
#include "apps/report/text.h"
#include "apps/watch/outlook.h"
#include "apps/watch/report.h"
#include "apps/watch/source.h"
#include "apps/watch/trial.h"
#include "apps/watch/update.h"

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
  Table table{
      .caption = "Health of the elements",
      .columns = {
          {"element", Align::kLeft}, {"health"}, {"in words", Align::kLeft}}};
  for (const ElementHealth& element : report.elements) {
    table.AddRow({PairName(report.model, element.output, element.input),
                  report::FormatFixed(element.health, 3),
                  element.health <= 0.5   ? "has aged, whatever the others did"
                  : element.health <= 0.9 ? "some evidence of ageing"
                                          : "no evidence of ageing"});
  }
  return table;
}

// By how much which parameter of an aged output has changed.
std::string ChangeNow(const Report& report, int output) {
  const auto i = static_cast<std::size_t>(output);
  if (i < report.outlook.trends.size()) {
    std::string changed =
        ChangedText(report.model, output, report.outlook.trends[i]);
    if (!changed.empty()) return changed;
  }
  return "Has aged; which parameter has changed is not known yet.";
}

std::string CorrectionNow(const Report& report) {
  if (report.watch->proposals.empty()) return "None has been run yet.";
  const Proposal& last = report.watch->proposals.back();
  const std::string text = absl::StrCat(
      "On ", NameOfDay(last.day), ": ",
      absl::StrReplaceAll(last.decision, {{"_", " "}}), " (below).");
  if (last.decision == "corrected") return text;
  return absl::StrCat(
      text,
      " The alarm rests on all days since the watch began, a correction on "
      "those since the change alone, and it has to predict records that it "
      "has not seen.");
}

std::string CostNow(const Report& report) {
  const AgeingCost& cost = report.cost;
  if (cost.state != AgeingCost::State::kTold) {
    return CostText(report.model, cost);
  }
  const bool corrected = !report.watch->proposals.empty() &&
                         report.watch->proposals.back().decision == "corrected";
  return absl::StrCat(CostText(report.model, cost), " ", UpdateText(cost),
                      cost.pays_now() && !corrected
                          ? " The records have not given a correction yet: see "
                            "the next change of a set point."
                          : "");
}

// What holds on the last day, where alarms and corrections say what was known
// on theirs.
void AddKnownNow(const Report& report, report::HtmlPage& page) {
  if (report.status != Status::kAged) return;
  page.AddHeading("What is known now");
  std::vector<std::pair<std::string, std::string>> terms;
  std::set<int> aged;
  for (const Alarm& alarm : AlarmsOfAgeing(report.watch->alarms)) {
    aged.insert(alarm.output);
  }
  for (const int output : aged) {
    if (output >= report.model.num_outputs()) continue;
    terms.emplace_back(report.model.outputs()[output].name,
                       ChangeNow(report, output));
  }
  terms.emplace_back("Correction", CorrectionNow(report));
  if (std::string cost = CostNow(report); !cost.empty()) {
    terms.emplace_back("Costs", std::move(cost));
  }
  page.AddTerms(terms);
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

Table AlarmTable(const char* caption) {
  return {.caption = caption,
          .columns = {{"day"},
                      {"what", Align::kLeft},
                      {"acknowledged", Align::kLeft},
                      {"handed on to", Align::kLeft},
                      {"id", Align::kLeft}},
          .stacked = true};
}

void AddAlarmRows(const Report& report, bool can_acknowledge,
                  report::HtmlPage& page) {
  page.AddHeading("Alarms");
  if (report.watch->alarms.empty()) {
    page.AddParagraph("None was raised.");
    return;
  }
  page.AddParagraph("Each says what was known on its day.");
  Table last = AlarmTable("The last alarm of each output and of the trial");
  Table before = AlarmTable("Alarms before these");
  std::map<int, const Alarm*> last_of_output;
  for (const Alarm& alarm : report.watch->alarms) {  // in order of time
    last_of_output[alarm.output] = &alarm;
  }
  for (const Alarm& alarm : report.watch->alarms) {
    (last_of_output[alarm.output] == &alarm ? last : before)
        .AddRow({NameOfDay(alarm.day), alarm.text, AcknowledgementText(alarm),
                 DeliveryText(alarm), ShortId(alarm)});
  }
  page.AddTable(last);
  if (!before.rows.empty()) {
    page.OpenFold(before.caption);
    page.AddTable(before);
    page.CloseFold();
  }
  for (const Alarm& alarm : report.watch->alarms) {
    if (can_acknowledge && !alarm.acknowledged.has_value()) {
      AddAcknowledging(alarm, page);
    }
  }
}

void AddProposal(const Proposal& proposal, const std::string& folder,
                 report::HtmlPage& page) {
  page.AddParagraph(absl::StrCat(NameOfDay(proposal.day), ": ",
                                 proposal.decision, ". ", proposal.conclusion));
  const std::filesystem::path made =
      std::filesystem::path(proposal.folder) / "report.html";
  std::error_code error;
  if (!std::filesystem::exists(made, error)) return;
  page.AddFiles({{absl::StrCat("Report of ", NameOfDay(proposal.day)),
                  made.lexically_proximate(folder).generic_string()}});
}

void AddProposals(const Report& report, const std::string& folder,
                  report::HtmlPage& page) {
  const std::vector<Proposal>& proposals = report.watch->proposals;
  if (proposals.empty()) return;
  page.AddHeading("Corrections");
  page.AddParagraph(
      "Run on the records since the change most likely began, of 60 days at "
      "most. Nothing is written to a controller: whether a correction is taken "
      "is for an engineer to say.");
  AddProposal(proposals.back(), folder, page);
  if (proposals.size() == 1) return;
  page.OpenFold("Corrections before");
  for (std::size_t k = 0; k + 1 < proposals.size(); ++k) {
    AddProposal(proposals[k], folder, page);
  }
  page.CloseFold();
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
  // Of a model that has aged this has been said (AddKnownNow).
  if (report.status != Status::kAged && !text.empty()) {
    page.AddHeading("Costs of ageing");
    page.AddParagraph(text);
    page.AddParagraph(UpdateText(cost));
  }
  if (cost.state != AgeingCost::State::kTold ||
      cost.points.front().cost.mean == cost.points.back().cost.mean) {
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
  page.OpenFold("What ageing will cost, if it goes on");
  page.AddTable(table);
  page.CloseFold();
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
  const bool aged = report.status == Status::kAged;
  if (report.trial.has_value()) AddTrial(*report.trial, page);
  AddKnownNow(report, page);
  if (aged) AddCost(report, page);
  AddAlarmRows(report, can_acknowledge, page);
  AddProposals(report, folder, page);
  if (!aged) AddCost(report, page);
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

std::string PageName(const Report& report) {
  return absl::StrCat("controller-", FileNameOf(report.name), ".html");
}

}  // namespace mle::watch
