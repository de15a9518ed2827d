#include "apps/watch/health.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "apps/watch/source.h"
#include "apps/watch/trial.h"
#include "apps/watch/update.h"

namespace mle::watch {
namespace {

constexpr int kMonth = 30;

// The latest reason why nothing could be told.
std::string LastReason(const Watch& watch) {
  for (auto day = watch.days.rbegin(); day != watch.days.rend(); ++day) {
    if (day->second.state == BatchState::kCannotTell) {
      return absl::StrCat(NameOfDay(day->first), ": ", day->second.reason);
    }
  }
  return "";
}

// Those of outputs tell most: of the change and when it began.
Alarm LastAlarm(const Watch& watch) {
  const std::vector<Alarm> alarms = AlarmsOfAgeing(watch.alarms);
  const auto last =
      std::find_if(alarms.rbegin(), alarms.rend(),
                   [](const Alarm& alarm) { return alarm.element < 0; });
  return last == alarms.rend() ? alarms.back() : *last;
}

Status StatusOf(const Watch& watch) {
  if (watch.failed) return Status::kFailed;
  if (!AlarmsOfAgeing(watch.alarms).empty()) return Status::kAged;
  if (!watch.reference.has_value()) return Status::kLearning;
  bool doubtful = false;
  for (auto day = watch.days.rbegin();
       day != watch.days.rend() && day->first > watch.last_day() - kMonth;
       ++day) {
    if (day->second.state == BatchState::kUsed) return Status::kHealthy;
    doubtful = doubtful || day->second.state == BatchState::kCannotTell;
  }
  return doubtful ? Status::kCannotTell : Status::kHealthy;
}

// The change that the evidence of all days shows now, where it shows one; else
// the alarm's text, which was written with the evidence up to its day.
std::string AgedSentence(const Report& report) {
  const Alarm alarm = LastAlarm(*report.watch);
  const auto output = static_cast<std::size_t>(alarm.output);
  if (output < report.outlook.trends.size()) {
    const std::string changed =
        ChangedText(report.model, alarm.output, report.outlook.trends[output]);
    if (!changed.empty()) {
      return absl::StrCat("The model of ", report.model.outputs()[output].name,
                          " has aged. ", changed);
    }
  }
  return alarm.text;
}

std::string SentenceOf(const Report& report) {
  const Watch& watch = *report.watch;
  switch (report.status) {
    case Status::kFailed:
    case Status::kLearning:
      return watch.news;
    case Status::kAged:
      return AgedSentence(report);
    case Status::kCannotTell:
      return absl::StrCat("Nothing could be told for a month. ",
                          LastReason(watch));
    case Status::kHealthy:
      return report.used_days == 0
                 ? "Nothing has moved yet: no evidence for or against the "
                   "model."
                 : absl::StrCat("No evidence of ageing in ", report.used_days,
                                " days with changes of set points.");
  }
  return "";
}

}  // namespace

std::string_view NameOf(Status status) {
  constexpr std::string_view kNames[] = {"failed", "learning", "aged",
                                         "cannot_tell", "healthy"};
  return kNames[static_cast<int>(status)];
}

std::string_view WordsFor(Status status) {
  return status == Status::kCannotTell ? "cannot tell" : NameOf(status);
}

Report MakeReport(const Controller& controller, const ProcessModel& model,
                  const Watch& watch, const Report* known) {
  Report report;
  report.name = controller.name;
  report.watch = &watch;
  report.model = model;
  report.status = StatusOf(watch);
  if (!watch.days.empty()) report.last_day = watch.last_day();
  for (const auto& [number, day] : watch.days) {
    report.used_days += day.state == BatchState::kUsed ? 1 : 0;
    report.unused_days += day.state == BatchState::kCannotTell ? 1 : 0;
  }
  const double of_output = ShareOfOutput(model, controller.options);
  const double of_element = ShareOfElement(model, controller.options);
  for (int i = 0; i < model.num_outputs(); ++i) {
    std::vector<HealthPoint>& trend = report.trends.emplace_back();
    const ChangeEvidence* last = nullptr;
    for (const auto& [number, stored] : watch.outputs[i]) {
      last = &stored.evidence;
      trend.push_back(
          {watch.first + last->number, HealthOf(last->log_output, of_output)});
    }
    report.output_health.push_back(trend.empty() ? 1.0 : trend.back().health);
    report.health = std::min(report.health, report.output_health.back());
    std::size_t present = 0;
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (model.element(i, j).IsZero()) continue;
      ElementHealth element{.output = i, .input = j};
      if (last != nullptr && present < last->log_elements.size()) {
        element.log_evidence = last->log_elements[present];
      }
      element.health = HealthOf(element.log_evidence, of_element);
      report.health = std::min(report.health, element.health);
      report.elements.push_back(element);
      ++present;
    }
  }
  if (known != nullptr) {
    report.outlook = known->outlook;
    report.cost = known->cost;
  } else if (model.num_outputs() > 0) {
    report.outlook = MakeOutlook(controller, model, watch);
    report.cost = CostOfAgeing(controller, model, watch, report.outlook.trends);
  }
  const absl::StatusOr<double> seconds = SecondsOf(model);
  report.trial = MakeTrialReport(watch, seconds.ok() ? *seconds : 60.0);
  report.sentence = SentenceOf(report);
  return report;
}

}  // namespace mle::watch
