// The pages of all controllers and of all alarms.

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/report/html.h"
#include "apps/report/table.h"
#include "apps/report/text.h"
#include "apps/watch/report.h"
#include "apps/watch/source.h"
#include "apps/watch/trial.h"

namespace mle::watch {
namespace {

using report::Align;
using report::FormatInteger;
using report::Table;

int CountOf(const std::vector<Report>& reports, Status status) {
  return static_cast<int>(std::count_if(
      reports.begin(), reports.end(),
      [&](const Report& report) { return report.status == status; }));
}

// "2 open", or who acknowledged the last one and when.
std::string AlarmsText(const Report& report) {
  const int open = CountOpen(report.watch->alarms);
  if (open > 0) return absl::StrCat(open, " open");
  const Alarm* last = nullptr;
  for (const Alarm& alarm : report.watch->alarms) {
    if (last == nullptr || alarm.acknowledged->at > last->acknowledged->at) {
      last = &alarm;
    }
  }
  if (last == nullptr) return "none";
  return absl::StrCat("acknowledged by ", last->acknowledged->who, " at ",
                      TimeText(last->acknowledged->at));
}

// The trend of the output with the least health, in a few words.
std::string ShortTrend(const Report& report) {
  const std::vector<OutputTrend>& trends = report.outlook.trends;
  if (trends.empty()) return "–";
  const auto least = std::min_element(report.output_health.begin(),
                                      report.output_health.end());
  const OutputTrend& trend =
      trends[static_cast<std::size_t>(least - report.output_health.begin())];
  switch (trend.course.state) {
    case AgeingCourse::State::kTrend:
      return absl::StrCat(ParameterName(trend.course.parameter), " ",
                          RateText(report.model, trend));
    case AgeingCourse::State::kSteady:
      return "steady";
    default:
      return "cannot tell";
  }
}

// How soon somebody should look: 0 first.
int UrgencyOf(const Report& report) {
  if (CountOpen(report.watch->alarms) > 0) return 0;
  switch (report.status) {
    case Status::kAged:
      return 3;
    case Status::kFailed:
      return 1;
    case Status::kCannotTell:
      return 2;
    case Status::kLearning:
      return 4;
    case Status::kHealthy:
      return 5;
  }
  return 5;
}

std::vector<const Report*> ByUrgency(const std::vector<Report>& reports) {
  std::vector<const Report*> order;
  for (const Report& report : reports) order.push_back(&report);
  std::stable_sort(order.begin(), order.end(),
                   [](const Report* left, const Report* right) {
                     return UrgencyOf(*left) < UrgencyOf(*right);
                   });
  return order;
}

void AddAlarmSentences(const std::vector<Report>& reports,
                       report::Verdict& verdict) {
  int open = 0;
  int undelivered = 0;
  for (const Report& report : reports) {
    open += CountOpen(report.watch->alarms);
    for (const Alarm& alarm : report.watch->alarms) {
      undelivered += std::any_of(std::begin(kChannels), std::end(kChannels),
                                 [&](Channel channel) {
                                   return IsUndelivered(alarm, channel);
                                 })
                         ? 1
                         : 0;
    }
  }
  if (open > 0) {
    verdict.sentences.push_back(absl::StrCat(Counted(open, "alarm"),
                                             open == 1 ? " is" : " are",
                                             " not acknowledged."));
  }
  if (undelivered > 0) {
    verdict.sentences.push_back(
        absl::StrCat(Counted(undelivered, "alarm"),
                     " could not be handed on; the next run tries again."));
  }
}

}  // namespace

std::string FormatOverview(const std::vector<Report>& reports,
                           const std::string& fault) {
  report::HtmlPage page("Watched models");
  const int aged = CountOf(reports, Status::kAged);
  const int failed = CountOf(reports, Status::kFailed);
  const int total = static_cast<int>(reports.size());
  report::Verdict verdict{.badge = aged > 0     ? report::Badge::kChanged
                                   : failed > 0 ? report::Badge::kUnknown
                                                : report::Badge::kGood,
                          .label = aged > 0     ? "aged"
                                   : failed > 0 ? "incomplete"
                                                : "no alarm",
                          .headline = absl::StrCat(
                              FormatInteger(aged), " of ", FormatInteger(total),
                              " models ", aged == 1 ? "has" : "have", " aged")};
  if (!fault.empty()) {
    verdict.sentences.push_back(
        absl::StrCat("This is what was read before: ", fault));
  }
  if (failed > 0) {
    verdict.sentences.push_back(
        absl::StrCat(FormatInteger(failed), " of ", FormatInteger(total),
                     " controllers could not be looked at."));
  }
  AddAlarmSentences(reports, verdict);
  page.SetVerdict(std::move(verdict));
  page.AddFiles({{"All alarms", kAlarmsPage}});
  Table table{.caption = "Controllers, those with alarms first",
              .columns = {{"controller", Align::kLeft},
                          {"health"},
                          {"status", Align::kLeft},
                          {"alarms", Align::kLeft},
                          {"trial", Align::kLeft},
                          {"last day"},
                          {"days used"},
                          {"trend", Align::kLeft},
                          {"costs a month"},
                          {"an update pays"},
                          {"what it says", Align::kLeft}},
              .sortable = true,
              .searchable = true,
              .choice = 2};
  for (const Report* report : ByUrgency(reports)) {
    table.AddRow({report->name, HealthText(*report),
                  std::string(WordsFor(report->status)), AlarmsText(*report),
                  ShortTrial(report->trial), LastDayOf(*report),
                  absl::StrCat(report->used_days), ShortTrend(*report),
                  ShortCost(report->cost), ShortDate(report->cost),
                  report->sentence});
    table.links.push_back(PageName(*report));
  }
  page.AddTable(table);
  page.AddParagraph(kMeaning);
  return page.Render();
}

std::string FormatAlarmsPage(const std::vector<Report>& reports) {
  report::HtmlPage page("Alarms of watched models");
  page.AddFiles({{"All controllers", kOverviewPage}});
  std::vector<std::pair<const Alarm*, const Report*>> alarms;
  for (const Report& report : reports) {
    for (const Alarm& alarm : report.watch->alarms) {
      alarms.emplace_back(&alarm, &report);
    }
  }
  if (alarms.empty()) {
    page.AddParagraph("None was raised.");
    return page.Render();
  }
  std::stable_sort(alarms.begin(), alarms.end(),
                   [](const auto& left, const auto& right) {
                     return left.first->day > right.first->day;
                   });
  Table table{.caption = "Alarms, the last ones first",
              .columns = {{"controller", Align::kLeft},
                          {"day"},
                          {"state", Align::kLeft},
                          {"what", Align::kLeft},
                          {"acknowledged", Align::kLeft},
                          {"handed on to", Align::kLeft},
                          {"id", Align::kLeft}},
              .sortable = true,
              .searchable = true,
              .choice = 2};
  for (const auto& [alarm, report] : alarms) {
    table.AddRow({report->name, NameOfDay(alarm->day),
                  alarm->acknowledged.has_value() ? "acknowledged" : "open",
                  alarm->text, AcknowledgementText(*alarm),
                  DeliveryText(*alarm), ShortId(*alarm)});
    table.links.push_back(PageName(*report));
  }
  page.AddTable(table);
  return page.Render();
}

}  // namespace mle::watch
