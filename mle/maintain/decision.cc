#include "mle/maintain/decision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/double_limits.h"
#include "mle/explain/competition.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

struct Horizon {
  HorizonScore OutputScores::*score;
  const char* name;
};
constexpr std::array<Horizon, 3> kHorizons = {
    {{&OutputScores::one_step, "one step ahead"},
     {&OutputScores::several_steps, "several steps ahead"},
     {&OutputScores::simulated, "simulated"}}};

// Scores that are not numbers are as bad as a fall.
bool Falls(const HorizonScore& score, double deviations) {
  return !(score.gain >= -deviations * score.error);
}

bool Gains(const HorizonScore& score, double deviations) {
  return score.gain > 0.0 && score.gain >= deviations * score.error;
}

const Horizon* FirstFall(const OutputScores& scores, double deviations) {
  for (const Horizon& horizon : kHorizons) {
    if (Falls(scores.*horizon.score, deviations)) return &horizon;
  }
  return nullptr;
}

const Horizon* FirstGain(const OutputScores& scores, double deviations) {
  for (const Horizon& horizon : kHorizons) {
    if (Gains(scores.*horizon.score, deviations)) return &horizon;
  }
  return nullptr;
}

// By which no error may grow where what is held out is the only judge.
constexpr double kWorseOfOnlyJudge = 1.05;

// Whether free simulation explains anything of what was held out: is nearer to
// it than its mean.
bool Explains(const OutputScores& scores) {
  return scores.simulated.corrected > 0.0;
}

bool Holds(const OutputScores& scores, double deviations,
           double worse = kWorse) {
  std::vector<double> ratios;
  for (const Horizon& horizon : kHorizons) {
    ratios.push_back(std::sqrt(1.0 - (scores.*horizon.score).gain));
  }
  return Explains(scores) && FallTogether(ratios, worse) &&
         FirstFall(scores, deviations) == nullptr &&
         FirstGain(scores, deviations) != nullptr;
}

// "window 2", those in which a score falls.
std::vector<std::string> WorseWindows(const OutputEvidence& output,
                                      double deviations) {
  const auto count = static_cast<double>(output.windows.size());
  std::vector<std::string> names;
  if (count < 2.0) return names;
  const double of_any = StudentTwoSidedQuantile(
      2.0 * StudentTail(deviations, kInfinity) / count, kInfinity);
  for (std::size_t w = 0; w < output.windows.size(); ++w) {
    const auto falls = [&](const Horizon& horizon) {
      const HorizonScore& score = output.windows[w].*horizon.score;
      return score.gain < -of_any * score.error;
    };
    if (std::any_of(kHorizons.begin(), kHorizons.end(), falls)) {
      names.push_back(absl::StrCat("window ", w + 1));
    }
  }
  return names;
}

// In per cent; of outputs that move far less than a model says it is far below
// 0.
std::string FitText(double fit) {
  return fit > -1e4 ? absl::StrFormat("%.1f %%", fit)
                    : absl::StrFormat("%.2g %%", fit);
}

std::string DescribeScore(const HorizonScore& score, const char* horizon) {
  return absl::StrCat(horizon, ", where its fit is ", FitText(score.corrected),
                      " after ", FitText(score.initial));
}

Message Doubt(const OutputEvidence& output, MessageCode code,
              std::string text) {
  return {code, output.name, std::move(text), {}};
}

struct OutputVerdict {
  Acceptance acceptance = Acceptance::kNothing;
  std::optional<Message> reason;
};

Message NotValidated(const OutputEvidence& output,
                     const std::string& nothing_held_out) {
  return Doubt(
      output, MessageCode::kNothingHeldOut,
      absl::StrCat("The correction of ", output.name,
                   " could not be validated on data that it had not seen: ",
                   nothing_held_out, "."));
}

Message WorseIn(const OutputEvidence& output,
                const std::vector<std::string>& windows) {
  return Doubt(
      output, MessageCode::kWindowsDisagree,
      absl::StrCat("The correction of ", output.name, " predicts ",
                   absl::StrJoin(windows, ", "),
                   " worse, the other windows better: the plant changed "
                   "during the records, is not linear over their operating "
                   "points, or was disturbed. Records of one operating point "
                   "after the change would settle it."));
}

Message Better(const OutputEvidence& output, double deviations) {
  const Horizon& gain = *FirstGain(*output.scores, deviations);
  return Doubt(
      output, MessageCode::kPredictsBetter,
      absl::StrCat("On held-out data the correction of ", output.name,
                   " predicts better ",
                   DescribeScore((*output.scores).*gain.score, gain.name),
                   "."));
}

Message ExplainsNothing(const OutputEvidence& output) {
  return Doubt(
      output, MessageCode::kStructureDoubtful,
      absl::StrFormat("On held-out data the correction of %s simulates worse "
                      "than a constant (fit %.1f %%): something moves it that "
                      "is not an input of the model, or the plant is not "
                      "linear. Records near one operating point would settle "
                      "it.",
                      output.name, output.scores->simulated.corrected));
}

Message NotTogether(const OutputEvidence& output) {
  std::vector<std::string> fits;
  for (const Horizon& horizon : kHorizons) {
    const HorizonScore& score = (*output.scores).*horizon.score;
    fits.push_back(absl::StrCat(FitText(score.corrected), " after ",
                                FitText(score.initial), " ", horizon.name));
  }
  return Doubt(output, MessageCode::kNotBetter,
               absl::StrCat("On held-out data the correction of ", output.name,
                            " predicts no better over all horizons together: "
                            "its fit is ",
                            absl::StrJoin(fits, ", "),
                            ". More set-point changes would settle it."));
}

Message NotBetter(const OutputEvidence& output, double deviations) {
  const Horizon* const fall = FirstFall(*output.scores, deviations);
  if (fall == nullptr && FirstGain(*output.scores, deviations) != nullptr) {
    return Explains(*output.scores) ? NotTogether(output)
                                    : ExplainsNothing(output);
  }
  if (fall == nullptr) {
    return Doubt(
        output, MessageCode::kNotBetter,
        absl::StrCat("On held-out data the correction of ", output.name,
                     " predicts no better than chance: more "
                     "set-point changes would settle it."));
  }
  return Doubt(
      output, MessageCode::kPredictsWorse,
      absl::StrCat("On held-out data the correction of ", output.name,
                   " predicts worse ",
                   DescribeScore((*output.scores).*fall->score, fall->name),
                   ": a disturbance looks like a change of the model, or "
                   "its structure does not fit the plant."));
}

Message ByInstruments(const OutputEvidence& output) {
  return Doubt(output, MessageCode::kPredictsBetter,
               absl::StrCat("On held-out data the correction of ", output.name,
                            " predicts better: ", output.instruments->errors,
                            ".", output.instruments->other.empty() ? "" : " ",
                            output.instruments->other));
}

Message NotConfirmed(const OutputEvidence& output) {
  const InstrumentEvidence& judge = *output.instruments;
  std::string text;
  if (judge.by_set_points || !judge.feedback_p_value.has_value()) {
    text = absl::StrCat(
        "but what ", judge.by_set_points ? "set points" : "moves of the inputs",
        " drive of it does not confirm it: a disturbance that the controller "
        "answers looks like this. More set-point changes would settle it.");
  } else if (*judge.feedback_p_value < kFeedback) {
    text = absl::StrFormat(
        "but no set point changes, and the inputs answer %s (p = %.2g for "
        "no feedback): what a controller answers looks like this. "
        "Records with set points that change would settle it.",
        output.name, *judge.feedback_p_value);
  } else {
    text =
        "but what moves of the inputs drive of it, and data held out, do not "
        "confirm it. More moves of the inputs would settle it.";
  }
  return Doubt(
      output, MessageCode::kNotConfirmed,
      absl::StrCat("A change of ", output.name, " is proposed, ", text));
}

OutputVerdict NotTaken(Message reason) {
  return {Acceptance::kNothing, std::move(reason)};
}

// Whether the proposal's error of free simulation of what was held out is by
// almost a third below that of what won.
bool SimulatesBetter(const OutputEvidence& output) {
  constexpr double kBetter = 0.7;
  return std::sqrt(1.0 - output.scores->simulated.gain) <
         kBetter * output.instruments->simulated;
}

// By what set points, or other instruments, drive of the residual.
OutputVerdict DecideByInstruments(const OutputEvidence& output,
                                  const DecisionOptions& options) {
  constexpr double kMissing = 3.0;  // E/N
  const InstrumentEvidence& judge = *output.instruments;
  const bool holds = output.proposed && output.scores.has_value() &&
                     (judge.confirms_proposal ||
                      (judge.allows_proposal && SimulatesBetter(output))) &&
                     Holds(*output.scores, options.deviations,
                           judge.by_set_points ? kWorse : kWorseOfOnlyJudge);
  if (holds) {
    return {Acceptance::kProposal, Better(output, options.deviations)};
  }
  if (judge.ageing) {
    if (!judge.tie.empty()) {
      return NotTaken(Doubt(output, MessageCode::kExplained, judge.tie));
    }
    if (judge.predicts_better &&
        (!judge.another_in_use ||
         (output.scores.has_value() &&
          Holds(*output.scores, options.deviations)))) {
      return {Acceptance::kExplained, ByInstruments(output)};
    }
    if (judge.errors.empty()) {
      return NotTaken(NotValidated(
          output, "the records are shorter than six time constants"));
    }
    return NotTaken(
        Doubt(output, MessageCode::kNotBetter,
              absl::StrCat("On held-out data the correction of ", output.name,
                           " predicts no better: ", judge.errors,
                           ". More set-point changes would settle it.")));
  }
  if (!judge.other.empty()) {
    Message other = Doubt(output, judge.code, judge.other);
    if (judge.code == MessageCode::kClock) other.options = {"clock_error"};
    return NotTaken(std::move(other));
  }
  if (judge.left > kMissing) {
    return NotTaken(
        Doubt(output, MessageCode::kMissingExplanation,
              absl::StrFormat(
                  "%s drive %s otherwise than the model says "
                  "(%.2g times what disturbances make of it by chance), "
                  "and no explanation known here accounts for it: a "
                  "disturbance that comes with %s, or another structure. "
                  "Single set-point changes in steady operation would "
                  "settle it.",
                  judge.by_set_points ? "Set points" : "Inputs", output.name,
                  judge.left,
                  judge.by_set_points ? "set-point changes" : "their moves")));
  }
  if (output.proposed && !judge.refutes_proposal) {
    return NotTaken(NotConfirmed(output));
  }
  return {};
}

OutputVerdict DecideOutput(const OutputEvidence& output,
                           const std::string& nothing_held_out,
                           const DecisionOptions& options) {
  if (output.instruments.has_value()) {
    return DecideByInstruments(output, options);
  }
  if (!output.proposed) return {};
  if (!output.scores.has_value()) {
    return {
        options.require_hold_out ? Acceptance::kNothing : Acceptance::kProposal,
        NotValidated(output, nothing_held_out)};
  }
  const double deviations = options.deviations;
  if (!Holds(*output.scores, deviations)) {
    return NotTaken(NotBetter(output, deviations));
  }
  if (const std::vector<std::string> worse = WorseWindows(output, deviations);
      !worse.empty()) {
    return NotTaken(WorseIn(output, worse));
  }
  return {Acceptance::kProposal, Better(output, deviations)};
}

// The judge of an output by which something that is proposed would have shown
// in what set points drive, or of any output.
const InstrumentEvidence* JudgeOf(const Evidence& evidence, bool refutes) {
  for (const OutputEvidence& output : evidence.outputs) {
    if (!output.instruments.has_value()) continue;
    if (!refutes || (output.proposed && output.instruments->refutes_proposal)) {
      return &*output.instruments;
    }
  }
  return nullptr;
}

Message Agrees(const InstrumentEvidence& judge, const std::string& p,
               const std::string& detectable) {
  return {
      MessageCode::kSetPointsAgree,
      "",
      absl::StrCat("The records differ from the model (", p, "), but what ",
                   judge.by_set_points ? "set points" : "moves of the inputs",
                   " drive agrees with it: the difference is no more than "
                   "disturbances make by chance.",
                   detectable.empty() ? "" : " ", detectable),
      {}};
}

absl::Status CheckField(const char* field, double value, double low,
                        double high, const char* range) {
  if (value >= low && value < high && std::isfinite(value)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("decision.", field, " = ", value, ": it must be ", range));
}

}  // namespace

bool FallTogether(const std::vector<double>& ratios, double worse) {
  double log_ratio = 0.0;
  for (const double ratio : ratios) {
    if (!(ratio < worse)) return false;
    log_ratio += std::log(std::max(ratio, 1e-300));
  }
  return log_ratio < 0.0;
}

std::string_view NameOf(Decision decision) {
  switch (decision) {
    case Decision::kNoChange:
      return "no_change";
    case Decision::kCorrected:
      return "corrected";
    case Decision::kCannotTell:
      return "cannot_tell";
  }
  return "";
}

absl::Status DecisionOptions::Validate() const {
  constexpr double kLeast = 1e-300;
  constexpr double kMost = 1e300;
  for (const absl::Status& status :
       {CheckField("deviations", deviations, kLeast, kMost,
                   "finite and greater than 0"),
        CheckField("least_change", least_change, 0.0, 1.0, "in [0, 1)"),
        CheckField("clock_error", clock_error, 0.0, kMost,
                   "finite and not negative")}) {
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

Verdict Decide(const Evidence& evidence, const DecisionOptions& options) {
  Verdict verdict;
  verdict.outputs.assign(evidence.outputs.size(), Acceptance::kNothing);
  if (!evidence.obstacles.empty()) {
    verdict.decision = Decision::kCannotTell;
    verdict.reasons = evidence.obstacles;
    return verdict;
  }
  constexpr double kLeastShown = 1e-300;  // near the least of all doubles
  constexpr double kDiffer = 1e-6;        // records as a whole, and the model
  const std::string p =
      evidence.p_value < kLeastShown
          ? "p < 1e-300 for no change"
          : absl::StrFormat("p = %#.2g for no change", evidence.p_value);
  std::vector<Message> taken;
  std::vector<Message> doubts;
  verdict.reasons = evidence.doubts;
  for (std::size_t i = 0; i < evidence.outputs.size(); ++i) {
    if (evidence.outputs[i].undecidable) continue;
    OutputVerdict output =
        DecideOutput(evidence.outputs[i], evidence.nothing_held_out, options);
    verdict.outputs[i] = output.acceptance;
    if (!output.reason.has_value()) continue;
    (output.acceptance == Acceptance::kNothing ? doubts : taken)
        .push_back(*std::move(output.reason));
  }
  if (!taken.empty() || !doubts.empty()) {
    verdict.decision =
        taken.empty() ? Decision::kCannotTell : Decision::kCorrected;
    if (evidence.change_proved) {
      verdict.reasons.push_back(
          {MessageCode::kChangeProved,
           "",
           absl::StrCat("The records differ from the model (", p, ")."),
           {}});
    }
  } else if (!evidence.doubts.empty()) {
    verdict.decision = Decision::kCannotTell;
  } else if (const InstrumentEvidence* const refuting =
                 JudgeOf(evidence, true)) {
    verdict.reasons.push_back(Agrees(*refuting, p, evidence.detectable));
  } else if (evidence.change_proved) {
    verdict.reasons.push_back(
        {MessageCode::kChangeTooSmall,
         "",
         absl::StrFormat("The records differ from the model (%s), but no step "
                         "response changes by more than %.3g %%.",
                         p, 100.0 * options.least_change),
         {"least_change"}});
  } else if (!evidence.uninformed.empty()) {
    verdict.decision = Decision::kCannotTell;
    verdict.reasons.push_back(
        {MessageCode::kNotExcited, "", evidence.uninformed, {}});
  } else if (const InstrumentEvidence* const any = JudgeOf(evidence, false);
             any != nullptr && evidence.p_value < kDiffer) {
    verdict.reasons.push_back(Agrees(*any, p, evidence.detectable));
  } else {
    verdict.reasons.push_back(
        {MessageCode::kNoChangeFound,
         "",
         absl::StrCat("The records agree with the model (", p, ").",
                      evidence.detectable.empty() ? "" : " ",
                      evidence.detectable),
         {}});
  }
  std::move(taken.begin(), taken.end(), std::back_inserter(verdict.reasons));
  std::move(doubts.begin(), doubts.end(), std::back_inserter(verdict.reasons));
  return verdict;
}

}  // namespace mle
