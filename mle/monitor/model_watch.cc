#include "mle/monitor/model_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/set_point_windows.h"
#include "mle/maintain/examine_records.h"
#include "mle/model/process_simulator.h"
#include "mle/monitor/output_scores.h"
#include "mle/monitor/record_jump.h"
#include "mle/monitor/reference_operation.h"
#include "mle/monitor/row_response.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::VectorXd;

constexpr int kLeastSamples = 20;
constexpr double kLeastDeviation = 0.1;  // of innovations, in √r
// Enough for a noise shape; more cost time.
constexpr int kMostForNoise = 6000;
constexpr int kMostLags = 120;
// Changes of a dead time up to this, in samples, may come from clocks and
// scans.
constexpr double kLeastDelay = 0.1;
// A batch is not used for an output if its information on every parameter,
// times the variance of the change expected, is less than this.
constexpr double kLeastInformation = 1e-3;
// Share of the reference's samples below the usual range, and share above it.
constexpr double kUnusual = 0.01;
// Tail of the noise beyond which a change is more than noise.
constexpr double kMoreThanNoise = 0.01;
// Changes agree unless their differences have a smaller p-value than this.
constexpr double kDisagree = 0.05;

// Until responses have settled, in samples: two years of minutes.
constexpr double kMostSettling = 1e6;

int InSamples(double time, double sample_time) {
  return static_cast<int>(std::ceil(time / sample_time - 1e-9));
}

// Leaves the outputs of samples from `first` on that are `wanted`.
void Mask(const std::vector<bool>& around, bool wanted, int first,
          Record& record) {
  for (int k = 0; k < record.samples(); ++k) {
    if (k < first || around[k] != wanted)
      record.outputs.col(k).setConstant(kNaN);
  }
}

// For each sample: how many segments that are `around` begin up to it.
std::vector<int> NumberSegments(const std::vector<bool>& around) {
  std::vector<int> numbers(around.size(), 0);
  int number = 0;
  for (std::size_t k = 0; k < around.size(); ++k) {
    if (around[k] && (k == 0 || !around[k - 1])) ++number;
    numbers[k] = number;
  }
  return numbers;
}

std::vector<std::vector<WhitenedRun>> ByGroup(std::vector<WhitenedRun> runs) {
  std::vector<std::vector<WhitenedRun>> groups;
  for (WhitenedRun& run : runs) {
    if (groups.empty() || groups.back().front().group != run.group) {
      groups.emplace_back();
    }
    groups.back().push_back(std::move(run));
  }
  return groups;
}

int UsableSamples(const std::vector<Record>& records, int output) {
  int count = 0;
  for (const Record& record : records) {
    count +=
        static_cast<int>(record.outputs.row(output).array().isFinite().count());
  }
  return count;
}

// The first of the records, until they have enough samples.
std::vector<Record> Enough(const std::vector<Record>& records, int output) {
  std::vector<Record> some;
  for (const Record& record : records) {
    some.push_back(record);
    if (UsableSamples(some, output) >= kMostForNoise) break;
  }
  return some;
}

// The good samples of a batch, of outputs and then inputs.
std::vector<double> ValuesOf(const WatchBatch& batch, int channel) {
  const int p = batch.record.num_outputs();
  std::vector<double> values;
  for (int k = batch.first; k < batch.record.samples(); ++k) {
    const double value = channel < p ? batch.record.outputs(channel, k)
                                     : batch.record.inputs(channel - p, k);
    if (std::isfinite(value)) values.push_back(value);
  }
  return values;
}

void FindUsualRange(const std::vector<WatchBatch>& batches,
                    WatchReference& reference) {
  const Record& any = batches.front().record;
  const int channels = any.num_outputs() + any.num_inputs();
  reference.low.setZero(channels);
  reference.high.setZero(channels);
  for (int c = 0; c < channels; ++c) {
    std::vector<double> values;
    for (const WatchBatch& batch : batches) {
      const std::vector<double> some = ValuesOf(batch, c);
      values.insert(values.end(), some.begin(), some.end());
    }
    if (values.empty()) continue;
    std::sort(values.begin(), values.end());
    const auto last = static_cast<double>(values.size() - 1);
    reference.low(c) = values[static_cast<std::size_t>(kUnusual * last)];
    reference.high(c) =
        values[static_cast<std::size_t>(std::ceil((1.0 - kUnusual) * last))];
  }
}

}  // namespace

std::string_view NameOf(BatchState state) {
  switch (state) {
    case BatchState::kUsed:
      return "used";
    case BatchState::kNothingMoved:
      return "nothing_moved";
    case BatchState::kCannotTell:
      return "cannot_tell";
  }
  return "";
}

std::vector<std::string> BatchScores::Reasons() const {
  std::vector<std::string> reasons;
  for (const BatchOutput& output : outputs) {
    if (!output.reason.empty() && std::find(reasons.begin(), reasons.end(),
                                            output.reason) == reasons.end()) {
      reasons.push_back(output.reason);
    }
  }
  return reasons;
}

absl::StatusOr<ModelWatch> ModelWatch::Create(const ProcessModel& model,
                                              double sample_time,
                                              const WatchOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(model.Validate());
  if (!(sample_time > 0.0) || !std::isfinite(sample_time)) {
    return InvalidArgument("watch: the sample time is ", sample_time,
                           "; it must be > 0");
  }
  ModelWatch watch;
  watch.model_ = model;
  watch.options_ = options;
  watch.sample_time_ = sample_time;
  const double settling = SettlingTime(model);
  if (!(settling > 0.0)) {
    return absl::InvalidArgumentError(
        "watch: no element has a dead time or a time constant, so that how "
        "long a change takes is not known");
  }
  if (!(settling / sample_time <= kMostSettling)) {
    return InvalidArgument("watch: responses of the model settle after ",
                           settling, " ", model.time_unit(), ", more than ",
                           kMostSettling, " samples of ", sample_time,
                           "; compare its times with its time unit");
  }
  watch.skip_ = InSamples(settling, sample_time) + 1;
  watch.before_ = InSamples(0.5 * settling, sample_time);
  watch.after_ = InSamples(1.5 * settling, sample_time);
  std::vector<RowResponse> rows;
  for (int i = 0; i < model.num_outputs(); ++i) {
    MLE_ASSIGN_OR_RETURN(
        RowResponse row,
        RowResponse::Create(model, i, sample_time, watch.skip_));
    rows.push_back(std::move(row));
  }
  watch.rows_ =
      std::make_shared<const std::vector<RowResponse>>(std::move(rows));
  return watch;
}

const std::vector<int>& ModelWatch::inputs(int output) const {
  return (*rows_)[output].inputs();
}

const VectorXd& ModelWatch::units(int output) const {
  return (*rows_)[output].units();
}

VectorXd ModelWatch::LeastChanges(int output) const {
  const RowResponse& row = (*rows_)[output];
  VectorXd least =
      VectorXd::Constant(row.num_parameters(), options_.least_change);
  for (int a = 2; a < row.num_parameters(); a += 3) {
    least(a) = std::max(least(a), kLeastDelay * sample_time_ / row.units()(a));
  }
  return least;
}

absl::StatusOr<std::vector<bool>> ModelWatch::AroundChanges(
    const Record& record) const {
  MLE_RETURN_IF_ERROR(record.Validate());
  std::vector<bool> around(record.samples(), false);
  const std::vector<std::vector<SetPointChange>> changes =
      FindChanges({record}, WindowOptions());
  for (const SetPointChange& change : changes.front()) {
    const int from = std::max(change.sample - before_, 0);
    const int to = std::min(change.sample + after_, record.samples() - 1);
    std::fill(around.begin() + from, around.begin() + to + 1, true);
  }
  return around;
}

// The batches that are fit for use, repaired.
absl::StatusOr<std::vector<WatchBatch>> ModelWatch::Examined(
    const std::vector<WatchBatch>& batches) const {
  std::vector<WatchBatch> fit;
  for (const WatchBatch& batch : batches) {
    std::vector<Record> records = {batch.record};
    MLE_ASSIGN_OR_RETURN(const std::vector<Finding> findings,
                         ExamineRecords(model_, {}, records));
    if (FirstBlocking(findings) != nullptr) continue;
    fit.push_back({std::move(records.front()), batch.first});
  }
  return fit;
}

absl::StatusOr<std::vector<Record>> ModelWatch::AtRest(
    const std::vector<WatchBatch>& batches) const {
  std::vector<Record> rest;
  for (const WatchBatch& batch : batches) {
    MLE_ASSIGN_OR_RETURN(const std::vector<bool> around,
                         AroundChanges(batch.record));
    rest.push_back(batch.record);
    Mask(around, /*wanted=*/false, batch.first, rest.back());
  }
  return rest;
}

absl::StatusOr<WatchReference> ModelWatch::MakeReference(
    const std::vector<WatchBatch>& given) const {
  MLE_ASSIGN_OR_RETURN(const std::vector<WatchBatch> batches, Examined(given));
  if (batches.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "watch: none of the ", given.size(),
        " batches of the reference has records that are fit for use"));
  }
  MLE_ASSIGN_OR_RETURN(std::vector<Record> rest, AtRest(batches));
  WatchReference reference;
  FindUsualRange(batches, reference);
  reference.operation = OperationOf(batches, rest);
  for (int i = 0; i < model_.num_outputs(); ++i) {
    std::vector<Record> records = rest;
    if (UsableSamples(records, i) < kLeastReference) {
      // Always on the move: all of it.
      for (std::size_t b = 0; b < records.size(); ++b) {
        records[b] = batches[b].record;
      }
    }
    const int usable = UsableSamples(records, i);
    if (usable < kLeastReference) {
      return absl::FailedPreconditionError(absl::StrCat(
          "watch: output \"", model_.outputs()[i].name, "\" has ", usable,
          " usable samples in the reference period; at least ", kLeastReference,
          " are needed"));
    }
    OutputReference output;
    output.noise = (*rows_)[i].EstimateNoise(Enough(records, i));
    const double range = reference.high(i) - reference.low(i);
    output.noise.variance =
        std::max(output.noise.variance, 1e-12 * range * range);
    if (!(output.noise.variance > 0.0)) {
      return absl::FailedPreconditionError(
          absl::StrCat("watch: output \"", model_.outputs()[i].name,
                       "\" stands still in the reference period"));
    }
    std::vector<WhitenedRun> runs;
    for (const Record& record : records) {
      for (WhitenedRun& run : (*rows_)[i].Whiten(record, output.noise)) {
        runs.push_back(std::move(run));
      }
    }
    output.deviation = RobustDeviation(runs);
    // Most samples repeat the last one: the median says nothing.
    if (output.deviation < kLeastDeviation) output.deviation = 1.0;
    ClipInnovations(options_.clip * output.deviation, runs);
    output.covariances = AutocovariancesOf(runs, std::min(skip_, kMostLags));
    reference.outputs.push_back(std::move(output));
  }
  return reference;
}

// Where a channel is a whole range outside of its usual range for most of the
// batch.
std::string ModelWatch::OutOfRange(const WatchReference& reference,
                                   const WatchBatch& batch) const {
  const int p = model_.num_outputs();
  for (int c = 0; c < p + model_.num_inputs(); ++c) {
    const double range = reference.high(c) - reference.low(c);
    std::vector<double> values = ValuesOf(batch, c);
    if (!(range > 0.0) || values.empty()) continue;
    const auto middle =
        values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (*middle >= reference.low(c) - range &&
        *middle <= reference.high(c) + range) {
      continue;
    }
    return absl::StrFormat(
        "The operating point has moved: %s is at %.4g; in the reference it was "
        "from %.4g to %.4g.",
        c < p ? model_.outputs()[c].name : model_.inputs()[c - p].name, *middle,
        reference.low(c), reference.high(c));
  }
  return "";
}

absl::StatusOr<std::string> ModelWatch::RecordChange(
    const WatchReference& reference, const Record& record) const {
  VectorXd least(model_.num_outputs());
  for (int i = 0; i < model_.num_outputs(); ++i) {
    least(i) = std::sqrt(reference.outputs[i].noise.variance);
  }
  MLE_ASSIGN_OR_RETURN(const std::optional<int> jump,
                       FindRecordJump(model_, record, least));
  if (!jump.has_value()) return std::string();
  const double before = (record.samples() - *jump) * sample_time_;
  return absl::StrFormat(
      "The records have changed, not the plant: %.4g %s before the end of the "
      "day the outputs jump from one sample to the next. Have records been "
      "joined, or a unit, a range or a tag been exchanged?",
      before, model_.time_unit());
}

BatchOutput ModelWatch::ScoreOutput(const OutputReference& reference,
                                    const Record& record,
                                    const std::vector<int>& changes,
                                    int output) const {
  const RowResponse& row = (*rows_)[output];
  BatchOutput scores;
  if (row.num_parameters() == 0) return scores;
  std::vector<WhitenedRun> runs =
      row.Whiten(record, reference.noise, changes, reference.deviation);
  const double deviation =
      ClipAroundChange(options_.clip, reference.deviation, runs);
  const ScoreSums sums = SumScores(runs, row.num_parameters());
  const double expected = options_.change_deviation * options_.change_deviation;
  if (sums.samples < kLeastSamples ||
      sums.information.diagonal().maxCoeff() * expected < kLeastInformation) {
    return scores;
  }
  const double usual =
      reference.covariances.front() * static_cast<double>(sums.samples);
  const double unexplained = UnexplainedSquares(sums);
  if (unexplained > options_.disturbed * usual &&
      unexplained - usual > 0.5 * (sums.squares - usual)) {
    scores.state = BatchState::kCannotTell;
    scores.reason = absl::StrFormat(
        "%s is disturbed: its innovations are %.1f times as large as in the "
        "reference, and no change of the model explains that.",
        model_.outputs()[output].name, std::sqrt(unexplained / usual));
    return scores;
  }
  const double noise = std::max(deviation / reference.deviation, 1.0);
  scores.state = BatchState::kUsed;
  scores.score.setZero(row.num_parameters());
  scores.information.setZero(row.num_parameters(), row.num_parameters());
  double largest = -1.0;
  double apart = 0.0;
  ScorePart of_largest;
  const std::vector<std::vector<WhitenedRun>> groups = ByGroup(std::move(runs));
  for (const std::vector<WhitenedRun>& group : groups) {
    ScoreSums part = SumScores(group, row.num_parameters());
    if (!(part.information.diagonal().maxCoeff() > 0.0)) continue;
    AllowForVariance(
        noise * noise *
            ScoreVariance(group, reference.covariances, row.num_parameters()),
        part);
    scores.score += part.score;
    scores.information += part.information;
    const double size = ExplainedSquares(part.score, part.information);
    apart += size;
    if (size <= largest) continue;
    largest = size;
    of_largest = {std::move(part.score), std::move(part.information)};
  }
  if (groups.size() < 2) return scores;
  // The sum of squares that the parts explain by changes of their own, less
  // that explained by one change of the parameters common to all.
  const double disagree =
      apart - ExplainedSquares(scores.score, scores.information);
  const auto freedom = static_cast<double>(row.num_parameters()) *
                       static_cast<double>(groups.size() - 1);
  if (ChiSquareTail(largest, row.num_parameters()) < kMoreThanNoise &&
      ChiSquareTail(std::max(disagree, 0.0), freedom) > kDisagree) {
    scores.largest = std::move(of_largest);
  }
  return scores;
}

absl::StatusOr<BatchScores> ModelWatch::Score(const WatchReference& reference,
                                              WatchBatch batch) const {
  BatchScores scores;
  scores.outputs.resize(model_.num_outputs());
  MLE_ASSIGN_OR_RETURN(const std::vector<bool> around,
                       AroundChanges(batch.record));
  if (std::find(around.begin() + batch.first, around.end(), true) ==
      around.end()) {
    return scores;
  }
  MLE_ASSIGN_OR_RETURN(std::string reason,
                       RecordChange(reference, batch.record));
  if (reason.empty()) reason = OutOfRange(reference, batch);
  std::vector<Record> records = {std::move(batch.record)};
  MLE_ASSIGN_OR_RETURN(const std::vector<Finding> findings,
                       ExamineRecords(model_, {}, records));
  Record& record = records.front();
  Mask(around, /*wanted=*/true, batch.first, record);
  const std::vector<int> changes = NumberSegments(around);
  if (const Finding* blocking = FirstBlocking(findings); blocking != nullptr) {
    reason = blocking->message.text;
  }
  for (int i = 0; i < model_.num_outputs(); ++i) {
    BatchOutput& output = scores.outputs[i];
    output.reason = reason;
    for (const Finding& finding : findings) {
      if (finding.consequence == Consequence::kDoubts &&
          std::find(finding.outputs.begin(), finding.outputs.end(), i) !=
              finding.outputs.end()) {
        output.reason = finding.message.text;
      }
    }
    if (output.reason.empty()) {
      output = ScoreOutput(reference.outputs[i], record, changes, i);
    } else {
      output.state = BatchState::kCannotTell;
    }
    if (output.state == BatchState::kUsed ||
        scores.state == BatchState::kNothingMoved) {
      scores.state = output.state;
    }
  }
  return scores;
}

absl::StatusOr<std::vector<Eigen::MatrixXd>> ModelWatch::ExpectedInformation(
    const WatchReference& reference, const VectorXd& step) const {
  // Each of the two changes is scored by itself, as in Score().
  const int up = skip_ + before_;
  const int down = up + before_ + after_ + 2;
  const int samples = down + after_ + 1;
  Record record;
  record.sample_time = sample_time_;
  record.inputs.setZero(step.size(), samples);
  record.inputs.middleCols(up, down - up).colwise() += step;
  MLE_ASSIGN_OR_RETURN(record.outputs,
                       SimulateResponse(model_, sample_time_, record.inputs));
  std::vector<bool> around(samples, false);
  for (const int change : {up, down}) {
    std::fill(around.begin() + change - before_,
              around.begin() + change + after_ + 1, true);
  }
  Mask(around, /*wanted=*/true, 0, record);
  const std::vector<int> changes = NumberSegments(around);
  std::vector<Eigen::MatrixXd> informations;
  for (int i = 0; i < model_.num_outputs(); ++i) {
    informations.push_back(
        ScoreOutput(reference.outputs[i], record, changes, i).information);
  }
  return informations;
}

}  // namespace mle
