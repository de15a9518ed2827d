#include "apps/watch/trial.h"

#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/watch/update.h"
#include "mle/base/status.h"
#include "mle/maintain/examine_records.h"
#include "mle/trial/model_trial.h"

namespace mle::watch {
namespace {

// After so many responses in use the former model is no longer looked at.
constexpr int kMostResponsesInUse = 100;
// Two models are the same where their step responses differ by less than this.
constexpr double kSameModel = 0.01;

Trial* Running(Watch& watch) {
  if (watch.trials.empty()) return nullptr;
  Trial& last = watch.trials.back();
  return last.ended.empty() && !last.proposed.empty() ? &last : nullptr;
}

absl::StatusOr<ModelTrial> ResumeTrial(const Trial& trial) {
  MLE_ASSIGN_OR_RETURN(const ProcessModel in_use,
                       ParseProcessModel(trial.in_use, "state"));
  MLE_ASSIGN_OR_RETURN(const ProcessModel proposed,
                       ParseProcessModel(trial.proposed, "state"));
  return ModelTrial::Resume(in_use, proposed, trial.sample_time, TrialOptions(),
                            trial.state);
}

bool IsSame(const ProcessModel& a, const std::string& json) {
  const absl::StatusOr<ProcessModel> b = ParseProcessModel(json, "state");
  return b.ok() && CheckSameChannels(a, "", *b, "").ok() &&
         CompareElements(a, *b).maxCoeff() <= kSameModel;
}

void AdoptTrial(Acknowledgement by, Trial& trial) {
  if (trial.adopted.has_value()) return;
  absl::StatusOr<ModelTrial> running = ResumeTrial(trial);
  if (!running.ok()) return;
  running->Adopt();
  trial.state = running->state();
  trial.adopted = std::move(by);
  trial.adopted_day = trial.last_day + 1;
}

void RaiseOf(const Trial& trial, AlarmKind kind, Watch& watch) {
  for (const Alarm& raised : watch.alarms) {
    if (raised.kind == kind && raised.began == trial.day) return;
  }
  Alarm alarm = {
      .kind = kind, .output = -1, .day = trial.last_day, .began = trial.day};
  const std::vector<std::string> sentences =
      TrialSentences(*MakeTrialReport(watch, 1.0));
  alarm.text = absl::StrCat(sentences[0], " ", sentences[1]);
  alarm.id = AlarmId(absl::StrCat(watch.controller, "\n", watch.basis, "\n",
                                  std::string(NameOf(kind)), "\n", trial.day));
  watch.alarms.push_back(std::move(alarm));
}

// An error says why the day is left out.
absl::Status LookAtDay(const DatedRecords& data, int day, Trial& trial) {
  MLE_ASSIGN_OR_RETURN(ModelTrial running, ResumeTrial(trial));
  WatchBatch batch = DayOf(data, day, running.Lead());
  if (batch.record.samples() == 0) return absl::OkStatus();
  const double begin = day * kSecondsOfDay / data.seconds_per_unit;
  batch.record.start_time = begin - batch.first * batch.record.sample_time;
  MLE_ASSIGN_OR_RETURN(
      const ProcessModel in_use,
      ParseProcessModel(
          trial.adopted.has_value() ? trial.proposed : trial.in_use, "state"));
  std::vector<Record> records = {std::move(batch.record)};
  MLE_ASSIGN_OR_RETURN(const std::vector<Finding> findings,
                       ExamineRecords(in_use, {}, records));
  if (const Finding* blocking = FirstBlocking(findings); blocking != nullptr) {
    return absl::FailedPreconditionError(blocking->message.text);
  }
  MLE_RETURN_IF_ERROR(running.Look(records.front(), batch.first));
  trial.state = running.state();
  return absl::OkStatus();
}

// What follows from the advice after a day.
void Conclude(Trial& trial, Watch& watch) {
  const TrialVerdict verdict = JudgeTrial(trial.state, TrialOptions());
  switch (verdict.advice) {
    case TrialAdvice::kAdopt:
      RaiseOf(trial, AlarmKind::kAdopt, watch);
      break;
    case TrialAdvice::kDrop:
      trial.ended = "dropped";
      RaiseOf(trial, AlarmKind::kDrop, watch);
      break;
    case TrialAdvice::kRollBack:
      RaiseOf(trial, AlarmKind::kRollBack, watch);
      break;
    case TrialAdvice::kKeep:
      if (verdict.responses >= kMostResponsesInUse) trial.ended = "kept";
      break;
    case TrialAdvice::kWait:
      break;
  }
}

}  // namespace

void BeginTrial(const ProcessModel& in_use, const ProcessModel& proposed,
                double sample_time, const std::vector<Record>& records, int day,
                Watch& watch) {
  Trial trial = {.day = day, .last_day = day, .sample_time = sample_time};
  absl::StatusOr<ModelTrial> begun =
      ModelTrial::Create(in_use, proposed, sample_time, TrialOptions());
  absl::Status status = begun.status();
  for (const Record& record : records) {
    if (status.ok()) status = begun->Learn(record);
  }
  if (status.ok()) {
    trial.in_use = FormatProcessModel(in_use);
    trial.proposed = FormatProcessModel(proposed);
    trial.state = begun->state();
  } else {
    trial.fault = std::string(status.message());
  }
  watch.trials.push_back(std::move(trial));
}

void TakeAdoption(Watch& watch) {
  Trial* const trial = Running(watch);
  if (trial == nullptr) return;
  for (const Alarm& alarm : watch.alarms) {
    if (alarm.began != trial->day || !alarm.acknowledged.has_value()) continue;
    if (alarm.kind == AlarmKind::kAdopt) {
      AdoptTrial(*alarm.acknowledged, *trial);
    }
    if (alarm.kind == AlarmKind::kRollBack) trial->ended = "rolled_back";
  }
}

void ContinueTrial(const DatedRecords& data, Watch& watch) {
  if (data.records.empty()) return;
  for (const int day : ClosedDays(data)) {
    Trial* const trial = Running(watch);
    if (trial == nullptr) return;
    if (day <= trial->last_day) continue;
    trial->last_day = day;
    const absl::Status status = LookAtDay(data, day, *trial);
    trial->fault =
        status.ok() ? "" : absl::StrCat(NameOfDay(day), ": ", status.message());
    Conclude(*trial, watch);
  }
}

std::vector<Trial> CarryTrials(const ProcessModel& model, const Watch& before) {
  std::vector<Trial> trials = before.trials;
  if (trials.empty()) return trials;
  Trial& last = trials.back();
  if (!last.ended.empty() || last.proposed.empty()) return trials;
  if (IsSame(model, last.proposed)) {
    AdoptTrial({.who = "the list of controllers"}, last);
  } else if (!IsSame(model, last.in_use)) {
    last.ended = "replaced";
  } else if (last.adopted.has_value()) {
    last.ended = "rolled_back";
  }
  return trials;
}

bool HasFailed(const Trial& trial) {
  return trial.ended == "dropped" || trial.ended == "rolled_back";
}

bool WaitsForRollBack(const Trial& trial) {
  return trial.ended.empty() &&
         JudgeTrial(trial.state, TrialOptions()).advice ==
             TrialAdvice::kRollBack;
}

}  // namespace mle::watch
