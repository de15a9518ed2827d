#include "mle/maintain/examine_records.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/compression.h"
#include "mle/data/input_spikes.h"
#include "mle/data/operation.h"
#include "mle/data/stuck_outputs.h"
#include "mle/maintain/answered_moves.h"
#include "mle/maintain/exchanged_set_points.h"
#include "mle/maintain/operator_mistakes.h"

namespace mle {
namespace {

// Outputs answer a move if they show more than this share of the model's
// response to it.
constexpr double kAnswered = 0.5;

// Spikes of an input, all together.
struct Spikes {
  int count = 0;
  double from = 0.0;
  double to = 0.0;
  double largest = 0.0;

  void Add(double time, const InputSpike& spike) {
    to = time;
    if (count++ == 0) from = to;
    largest = std::max(largest, std::abs(spike.value - spike.usual));
  }
};

class Examiner {
 public:
  Examiner(const ProcessModel& model, const ExamineOptions& options,
           std::vector<Record>& records)
      : model_(model), options_(options), records_(records) {}

  absl::StatusOr<std::vector<Finding>> Run();

 private:
  void FindCompressed();
  void FindCompressedInputs(bool outputs_too);
  void FindSpikes();
  void Report(int input, const Spikes& spikes, Consequence consequence,
              const char* what);
  TimeNames Times() const;
  absl::Status FindStuck();
  void FindOperation();
  void FindSetPoints();
  absl::Status FindMistakes();

  std::vector<SampleRow> Rows(bool outputs, int channel) const;
  Compression CompressionOf(int output) const;
  Finding& Add(MessageCode code, std::string tag, Consequence consequence,
               double value, std::string text);
  double Begin() const { return records_.front().time(0); }
  double End() const {
    return records_.back().time(records_.back().samples() - 1);
  }

  const ProcessModel& model_;
  const ExamineOptions& options_;
  std::vector<Record>& records_;
  std::vector<Finding> findings_;
};

std::vector<SampleRow> Examiner::Rows(bool outputs, int channel) const {
  std::vector<SampleRow> rows;
  for (const Record& record : records_) {
    rows.emplace_back((outputs ? record.outputs : record.inputs).row(channel));
  }
  return rows;
}

Finding& Examiner::Add(MessageCode code, std::string tag,
                       Consequence consequence, double value,
                       std::string text) {
  return findings_.emplace_back(
      Finding{.message = {code, std::move(tag), std::move(text), {}},
              .consequence = consequence,
              .from = Begin(),
              .to = End(),
              .value = value,
              .outputs = {}});
}

// What is declared of an output takes the place of what is found.
Compression Examiner::CompressionOf(int output) const {
  const Sampling declared = SamplingOf(model_.outputs()[output], options_.tags);
  if (declared.period == 0.0) {
    return FindCompression(Rows(true, output), Holding::kNever);
  }
  if (!declared.held) return {};
  return HeldBetween(Rows(true, output),
                     declared.period / records_.front().sample_time);
}

void Examiner::FindCompressed() {
  bool found_any = false;
  for (int i = 0; i < model_.num_outputs(); ++i) {
    const Compression found = CompressionOf(i);
    if (found.kind == Compression::Kind::kNone) continue;
    found_any |= !found.is_sampled;
    const std::string& name = model_.outputs()[i].name;
    Add(MessageCode::kCompressed, name, Consequence::kRepair,
        found.ArchivedShare(),
        absl::StrFormat(
            "%s: %.0f %% of the samples are %s by the historian%s, and only "
            "the others are used.",
            name, 100.0 * (1.0 - found.ArchivedShare()),
            found.kind == Compression::Kind::kLinear ? "interpolated" : "held",
            found.is_sampled
                ? absl::StrFormat(": one in %.3g is measured, as by a "
                                  "laboratory or an analyser",
                                  1.0 / found.ArchivedShare())
                : ""));
    if (!options_.repair) continue;
    for (std::size_t r = 0; r < records_.size(); ++r) {
      for (int k = 0; k < records_[r].samples(); ++k) {
        if (found.interpolated[r][k]) records_[r].outputs(i, k) = kNaN;
      }
    }
  }
  FindCompressedInputs(found_any);
}

// Between archived values an input was moved within the historian's deviation
// of the straight line; or it was moved along ramps, if outputs are as
// measured.
void Examiner::FindCompressedInputs(bool outputs_too) {
  for (int j = 0; j < model_.num_inputs(); ++j) {
    const Compression found =
        FindCompression(Rows(false, j), Holding::kByItself);
    if (found.kind == Compression::Kind::kNone) continue;
    const std::string& name = model_.inputs()[j].name;
    Add(MessageCode::kCompressed, name, Consequence::kNote,
        found.ArchivedShare(),
        absl::StrFormat("%s: %.0f %% of the samples lie on straight lines: %s.",
                        name, 100.0 * (1.0 - found.ArchivedShare()),
                        outputs_too
                            ? "interpolated by the historian"
                            : "ramps, or interpolated by the historian"));
  }
}

TimeNames Examiner::Times() const {
  return options_.times.has_dates() ? options_.times
                                    : TimeNames(model_.time_unit(), {});
}

// Whether the outputs answer the move: a controller's kick then.
bool IsKick(const ProcessModel& model, const Record& record, int input,
            const InputSpike& spike, std::optional<AnsweredMoves>& answers) {
  if (!answers.has_value()) {
    absl::StatusOr<AnsweredMoves> made = AnsweredMoves::Create(model, record);
    if (!made.ok()) return false;
    answers = *std::move(made);
  }
  return answers->Share(input, spike.sample, spike.value - spike.usual) >
         kAnswered;
}

void Examiner::FindSpikes() {
  // Made from the inputs as recorded, before any is repaired.
  std::vector<std::optional<AnsweredMoves>> answers(records_.size());
  for (int j = 0; j < model_.num_inputs(); ++j) {
    Spikes replaced;
    Spikes kicks;
    for (std::size_t r = 0; r < records_.size(); ++r) {
      Record& record = records_[r];
      for (const InputSpike& spike : FindInputSpikes(record, j)) {
        const bool is_kick = IsKick(model_, record, j, spike, answers[r]);
        (is_kick ? kicks : replaced).Add(record.time(spike.sample), spike);
        if (options_.repair && !is_kick) {
          record.inputs(j, spike.sample) = spike.usual;
        }
      }
    }
    Report(j, replaced, Consequence::kRepair, "replaced");
    Report(j, kicks, Consequence::kNote,
           "taken for moves, which the outputs answer");
  }
}

void Examiner::Report(int input, const Spikes& spikes, Consequence consequence,
                      const char* what) {
  if (spikes.count == 0) return;
  const std::string& name = model_.inputs()[input].name;
  Finding& finding =
      Add(MessageCode::kInputSpikes, name, consequence, spikes.count,
          absl::StrFormat("%s: %d single sample%s up to %.3g beyond both "
                          "neighbours, first at %s, %s.",
                          name, spikes.count, spikes.count == 1 ? "" : "s",
                          spikes.largest, Times().At(spikes.from), what));
  finding.from = spikes.from;
  finding.to = spikes.to;
}

absl::Status Examiner::FindStuck() {
  MLE_ASSIGN_OR_RETURN(const std::vector<StuckOutput> all,
                       FindStuckOutputs(records_, model_));
  for (const StuckOutput& stuck : all) {
    const std::string& name = model_.outputs()[stuck.output].name;
    const bool dead = stuck.kind == StuckOutput::Kind::kDead;
    const bool clipped = stuck.kind == StuckOutput::Kind::kClipped;
    Finding& finding =
        Add(MessageCode::kStuckOutput, name,
            dead ? Consequence::kDoubts : Consequence::kRepair, stuck.samples(),
            absl::StrFormat(
                "%s stands at %.6g for %d samples, %s: the sensor seems to be "
                "%s.",
                name, stuck.value, stuck.samples(),
                absl::StrFormat("while the model expects changes of %.3g",
                                stuck.expected),
                dead      ? "dead"
                : clipped ? "clipped; these samples are not used"
                          : "frozen; these samples are not used"));
    finding.from =
        records_[stuck.runs.front().record].time(stuck.runs.front().first);
    const SampleRun& last = stuck.runs.back();
    finding.to = records_[last.record].time(last.first + last.samples - 1);
    // Nothing is known of its output; of the others the records tell as ever.
    if (dead) finding.outputs = {stuck.output};
    if (!options_.repair) continue;
    for (Record& record : records_) {
      if (dead) record.outputs.row(stuck.output).setConstant(kNaN);
    }
    for (const SampleRun& run : stuck.runs) {
      records_[run.record]
          .outputs.row(stuck.output)
          .segment(run.first, run.samples)
          .setConstant(kNaN);
    }
  }
  return absl::OkStatus();
}

void Examiner::FindOperation() {
  for (const TimeAtLimits& limits : FindTimeAtLimits(records_)) {
    // An input that is only measured has no limits that a controller meets: the
    // sun at night, a feed that is stopped.
    if (model_.inputs()[limits.input].role == InputRole::kDisturbance) continue;
    const std::string& name = model_.inputs()[limits.input].name;
    const double share = limits.share_low + limits.share_high;
    // The model's response to an input is known at its limits too; how much the
    // other moves tell, the fit says.
    Add(MessageCode::kInputLimits, name, Consequence::kNote, share,
        absl::StrFormat("%s is at its limits for %.0f %% of the time: %.0f %% "
                        "at %.6g, %.0f %% at %.6g.",
                        name, 100.0 * share, 100.0 * limits.share_low,
                        limits.low, 100.0 * limits.share_high, limits.high));
  }
  for (const SplitMoves& moves : FindSplitMoves(records_)) {
    const std::string& name = model_.inputs()[moves.input].name;
    Add(MessageCode::kSplitMoves, name, Consequence::kNote,
        static_cast<double>(moves.split) / moves.moves,
        absl::StrFormat("%s: %d of %d moves happened between two samples; dead "
                        "times are uncertain by up to a sample.",
                        name, moves.split, moves.moves));
  }
  for (const SamplingRate& rate :
       FindUnusualSampling(model_, records_.front().sample_time)) {
    const std::string pair = PairName(model_, rate.output, rate.input);
    Add(MessageCode::kSampling, pair, Consequence::kNote, rate.samples,
        absl::StrFormat("%s: %.3g samples in a time constant; from 3 to 500 "
                        "are sensible.",
                        pair, rate.samples))
        .message.options = {"sample_time"};
  }
  for (const ManyMoves& moves : FindManySetPointMoves(records_, model_)) {
    const std::string& name = model_.outputs()[moves.output].name;
    Add(MessageCode::kManyMoves, name, Consequence::kNote, moves.moves,
        absl::StrFormat("%s: the set point moves %d times, by %.3g in the "
                        "median, as an optimiser moves it.",
                        name, moves.moves, moves.median_size))
        .message.options = {"min_setpoint_change"};
  }
}

// They decide where windows are, and nothing else.
void Examiner::FindSetPoints() {
  for (const ExchangedSetPoints& found : FindExchangedSetPoints(records_)) {
    const std::string& first = model_.outputs()[found.first].name;
    const std::string& second = model_.outputs()[found.second].name;
    Add(MessageCode::kMistake, first, Consequence::kRepair, found.ratio,
        absl::StrFormat("The set points of %s and %s seem to be swapped: "
                        "%s settles where the set point of %s is, and never at "
                        "its own%s.",
                        first, second, first, second,
                        options_.repair ? "; they are taken so" : ""));
    if (!options_.repair) continue;
    for (Record& record : records_) {
      record.set_points.row(found.first)
          .swap(record.set_points.row(found.second));
    }
  }
}

absl::Status Examiner::FindMistakes() {
  MLE_ASSIGN_OR_RETURN(const std::optional<OperatorMistake> mistake,
                       FindOperatorMistake(model_, records_, options_.threads));
  if (mistake.has_value()) {
    Add(MessageCode::kMistake, "", Consequence::kBlocks, mistake->factor,
        mistake->Describe(model_, options_.tags));
    return absl::OkStatus();
  }
  FindSetPoints();
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Finding>> Examiner::Run() {
  FindCompressed();
  FindSpikes();
  MLE_RETURN_IF_ERROR(FindStuck());
  FindOperation();
  MLE_RETURN_IF_ERROR(FindMistakes());
  const auto rank = [](const Finding& finding) {
    if (finding.message.code == MessageCode::kMistake) return 0;
    return finding.consequence == Consequence::kBlocks   ? 1
           : finding.consequence == Consequence::kDoubts ? 2
           : finding.consequence == Consequence::kRepair ? 3
                                                         : 4;
  };
  std::stable_sort(
      findings_.begin(), findings_.end(),
      [&](const Finding& a, const Finding& b) { return rank(a) < rank(b); });
  return std::move(findings_);
}

}  // namespace

absl::StatusOr<std::vector<Finding>> ExamineRecords(
    const ProcessModel& model, const ExamineOptions& options,
    std::vector<Record>& records) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (records.empty()) return std::vector<Finding>();
  return Examiner(model, options, records).Run();
}

}  // namespace mle
