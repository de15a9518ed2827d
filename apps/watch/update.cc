#include "apps/watch/update.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/common/option_table.h"
#include "apps/common/sha256.h"
#include "apps/report/text.h"
#include "apps/watch/outlook.h"
#include "apps/watch/source.h"
#include "apps/watch/trial.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

// Samples that come later than this change nothing: the days around them have
// been merged.
constexpr int kLatest = 60;

// The state keeps the lower triangle alone.
void Mirror(Eigen::MatrixXd& information) {
  const Eigen::MatrixXd whole = information.selfadjointView<Eigen::Lower>();
  information = whole;
}

class Update {
 public:
  Update(const Controller& controller, const ProcessModel& model, Watch& watch)
      : controller_(controller), model_(model), watch_(watch) {}

  absl::Status Run();

 private:
  absl::Status TakeReference(const ModelWatch& model, const NewRecords& news);
  absl::Status ScoreDays(const ModelWatch& model, const NewRecords& news);
  absl::Status ScoreDay(const ModelWatch& model, const WatchBatch& batch,
                        int day, std::string checksum);
  void CarryOn(const ModelWatch& model, int output, int from);
  void RaiseAlarms(const ModelWatch& model, int output, int number,
                   const ChangeEvidence& evidence,
                   const std::vector<ScoredBatch>& batches);
  void Raise(Alarm alarm);
  void Tell(std::string sentence) { news_.push_back(std::move(sentence)); }

  const Controller& controller_;
  const ProcessModel& model_;
  Watch& watch_;
  std::vector<std::string> news_;
  std::set<std::pair<int, int>> changed_;  // output, day
  int late_days_ = 0;
};

// The reference of the first days with records, or word of how many there are.
absl::Status Update::TakeReference(const ModelWatch& model,
                                   const NewRecords& news) {
  std::vector<WatchBatch> batches;
  for (const int day : ClosedDays(news.data)) {
    if (day < watch_.begin) continue;
    if (batches.empty()) watch_.first = day;
    batches.push_back(DayOf(news.data, day, model.lead()));
    if (static_cast<int>(batches.size()) == controller_.reference_days) break;
  }
  if (static_cast<int>(batches.size()) < controller_.reference_days) {
    Tell(absl::StrFormat("Learning the plant's noise: %d of %d days.",
                         batches.size(), controller_.reference_days));
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(watch_.reference, model.MakeReference(batches));
  watch_.sample_time = news.data.records.front().sample_time;
  watch_.begin = watch_.first;
  return absl::OkStatus();
}

absl::Status Update::ScoreDay(const ModelWatch& model, const WatchBatch& batch,
                              int day, std::string checksum) {
  MLE_ASSIGN_OR_RETURN(BatchScores scores,
                       model.Score(*watch_.reference, batch));
  watch_.days[day] = {.checksum = std::move(checksum),
                      .state = scores.state,
                      .reason = absl::StrJoin(scores.Reasons(), " ")};
  const int number = day - watch_.first;
  for (int i = 0; i < model_.num_outputs(); ++i) {
    std::map<int, StoredBatch>& stored = watch_.outputs[i];
    if (stored.erase(number) > 0) changed_.emplace(i, number);
    if (scores.outputs[i].state != BatchState::kUsed) continue;
    BatchOutput& output = scores.outputs[i];
    if (output.largest.has_value()) Mirror(output.largest->information);
    Mirror(output.information);
    stored[number].batch = {.number = number,
                            .length = 1,
                            .score = std::move(output.score),
                            .information = std::move(output.information),
                            .largest = std::move(output.largest)};
    changed_.emplace(i, number);
  }
  return absl::OkStatus();
}

absl::Status Update::ScoreDays(const ModelWatch& model,
                               const NewRecords& news) {
  // Samples up to this many seconds before a day act on it.
  const double acts = model.lead() * news.data.sample_seconds();
  const int settled = watch_.last_day() - kLatest;
  for (const int day : ClosedDays(news.data)) {
    const bool touched = (day + 1) * kSecondsOfDay > news.first &&
                         day * kSecondsOfDay - acts <= news.last;
    if (!touched || day < watch_.begin) continue;
    const WatchBatch batch = DayOf(news.data, day, model.lead());
    if (batch.record.samples() == 0) continue;
    std::string checksum = ChecksumOf(batch);
    const auto seen = watch_.days.find(day);
    if (seen != watch_.days.end() && seen->second.checksum == checksum) {
      continue;
    }
    if (day <= settled) {
      ++late_days_;
      continue;
    }
    MLE_RETURN_IF_ERROR(ScoreDay(model, batch, day, std::move(checksum)));
  }
  return absl::OkStatus();
}

void Update::Raise(Alarm alarm) {
  for (const Alarm& raised : watch_.alarms) {
    if (raised.kind == alarm.kind && raised.output == alarm.output &&
        raised.element == alarm.element) {
      return;
    }
  }
  alarm.id = AlarmId(absl::StrCat(watch_.controller, "\n", watch_.basis, "\n",
                                  watch_.first, "\n", alarm.output, "\n",
                                  alarm.element));
  watch_.alarms.push_back(std::move(alarm));
}

void Update::RaiseAlarms(const ModelWatch& model, int output, int number,
                         const ChangeEvidence& evidence,
                         const std::vector<ScoredBatch>& batches) {
  const WatchOptions& options = controller_.options;
  const double of_output = -std::log(ShareOfOutput(model_, options));
  const double of_element = -std::log(ShareOfElement(model_, options));
  const bool any = std::any_of(
      evidence.log_elements.begin(), evidence.log_elements.end(),
      [of_element](double element) { return element >= of_element; });
  if (!any && evidence.log_output < of_output) return;
  const LikelyChange likely =
      ExplainEvidence(batches, model.LeastChanges(output), options);
  Alarm alarm;
  alarm.output = output;
  alarm.day = watch_.first + number;
  alarm.began = watch_.first + likely.begin;
  if (evidence.log_output >= of_output) {
    alarm.text = absl::StrCat(
        "The model of ", model_.outputs()[output].name, " has aged. ",
        Describe(model_, output, likely, NameOfDay(alarm.began),
                 model.units(output)(3 * likely.element + 2)));
    Raise(alarm);
  }
  for (std::size_t e = 0; e < evidence.log_elements.size(); ++e) {
    if (evidence.log_elements[e] < of_element) continue;
    alarm.element = static_cast<int>(e);
    alarm.text = absl::StrCat("The element ",
                              PairName(model_, output, model.inputs(output)[e]),
                              " has aged, whatever the others did.");
    Raise(alarm);
  }
}

// The evidence after each batch from number `from` on; old batches are merged
// as they become old.
void Update::CarryOn(const ModelWatch& model, int output, int from) {
  std::map<int, StoredBatch>& stored = watch_.outputs[output];
  std::vector<ScoredBatch> batches;
  for (auto& [number, batch] : stored) {
    batches.push_back(batch.batch);
    if (number < from) continue;
    batches = MergeOld(batches, number);
    batch.evidence = ConfirmedEvidenceOf(batches, model.LeastChanges(output),
                                         controller_.options);
    RaiseAlarms(model, output, number, batch.evidence, batches);
  }
  std::map<int, StoredBatch> merged;
  for (const ScoredBatch& batch : batches) {
    // The evidence after the last of what was merged.
    const auto after =
        std::prev(stored.upper_bound(batch.number + batch.length - 1));
    merged[batch.number] = {batch, after->second.evidence};
  }
  stored = std::move(merged);
}

absl::Status Update::Run() {
  const std::string basis = BasisOf(controller_, model_);
  if (watch_.basis != basis) {
    Watch next;
    next.controller = controller_.name;
    next.basis = basis;
    next.begin = watch_.id == 0 ? 0 : watch_.last_day() + 1;
    next.outputs.resize(model_.num_outputs());
    next.trials = CarryTrials(model_, watch_);
    watch_ = std::move(next);
  }
  TakeAdoption(watch_);
  MLE_ASSIGN_OR_RETURN(std::optional<NewRecords> news,
                       ReadNew(controller_, model_, watch_));
  if (!news.has_value()) return absl::OkStatus();
  for (const std::string& fault : news->faults) Tell(fault);
  ContinueTrial(news->data, watch_);
  if (!news->data.records.empty()) {
    MLE_ASSIGN_OR_RETURN(
        const ModelWatch model,
        ModelWatch::Create(model_, news->data.records.front().sample_time,
                           controller_.options));
    if (!watch_.reference.has_value()) {
      MLE_RETURN_IF_ERROR(TakeReference(model, *news));
    }
    if (watch_.reference.has_value()) {
      MLE_RETURN_IF_ERROR(ScoreDays(model, *news));
      for (int i = 0; i < model_.num_outputs(); ++i) {
        const auto first = changed_.lower_bound({i, 0});
        if (first != changed_.end() && first->first == i) {
          CarryOn(model, i, first->second);
        }
      }
    }
  }
  if (late_days_ > 0) {
    Tell(absl::StrCat(late_days_,
                      " days whose records came or were changed more than ",
                      kLatest, " days late are not looked at again."));
  }
  // Until there is a reference everything is read again.
  if (watch_.reference.has_value()) {
    for (auto& [path, file] : news->files) watch_.files[path] = std::move(file);
  }
  watch_.news = absl::StrJoin(news_, " ");
  return absl::OkStatus();
}

}  // namespace

double ShareOfOutput(const ProcessModel& model, const WatchOptions& options) {
  return options.level / (2.0 * model.num_outputs());
}

double ShareOfElement(const ProcessModel& model, const WatchOptions& options) {
  return options.level / (2.0 * std::max(NumElements(model), 1));
}

std::string BasisOf(const Controller& controller, const ProcessModel& model) {
  const WatchOptions& options = controller.options;
  return Sha256Of(absl::StrCat(
      FormatProcessModel(model), "\n", controller.sample_time, "\n",
      controller.reference_days, "\n", ReadableNumber(options.level), "\n",
      ReadableNumber(options.least_change), "\n",
      ReadableNumber(options.model_error), "\n", options.life));
}

std::string Describe(const ProcessModel& model, int output,
                     const LikelyChange& likely, const std::string& since,
                     double delay_unit) {
  std::vector<int> present;
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (!model.element(output, j).IsZero()) present.push_back(j);
  }
  const std::string pair = PairName(model, output, present[likely.element]);
  const std::string size =
      likely.parameter == kDeadTime
          ? absl::StrCat(Signed(likely.change * delay_unit, 2), " ± ",
                         report::FormatFixed(likely.error * delay_unit, 2), " ",
                         model.time_unit())
          : absl::StrCat(Signed(100.0 * likely.change, 1), " ± ",
                         report::FormatFixed(100.0 * likely.error, 1), " %");
  return absl::StrFormat(
      "Most likely (%.0f %%) it is %s: its %s has changed by %s, since about "
      "%s.",
      100.0 * likely.probability, pair, ParameterName(likely.parameter), size,
      since);
}

absl::Status UpdateWatch(const Controller& controller,
                         const ProcessModel& model, Watch& watch) {
  return Update(controller, model, watch).Run();
}

}  // namespace mle::watch
