#include "mle/maintain/explained.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/maintain/aged_elements.h"
#include "mle/maintain/stamps.h"
#include "mle/model/element_response.h"

namespace mle {
namespace {

// Evidence that a proposal must have where nothing won by itself: 5 %, being
// one hypothesis, not the best of a table.
constexpr double kLeastEvidence = 3.0;
// How many times as much evidence where inputs stand for set points and answer.
constexpr double kWhereAnswered = 2.0;
// By how many M the likelihood's estimate may explain less than the best.
constexpr double kAgrees = 3.0;
// A proposal that is not confirmed is no doubt if no response changes by more
// than this share.
constexpr double kSmall = 0.2;
// By how many standard errors that of one horizon has to fall.
constexpr double kFallen = 1.5;

std::string Sentence(const ProcessModel& model, int output,
                     const Explanation& explanation) {
  const ExplanationType& type = TypeOf(explanation.kind);
  const std::string place = type.place == ExplanationPlace::kElement
                                ? PairName(model, output, explanation.index)
                            : type.place == ExplanationPlace::kOutput
                                ? model.outputs()[output].name
                                : model.inputs()[explanation.index].name;
  const std::string text = type.sentence;
  const std::size_t at = text.find("%s");
  return absl::StrCat(text.substr(0, at), place, text.substr(at + 2));
}

MessageCode CodeOf(ExplanationKind kind) {
  if (IsClock(kind)) return MessageCode::kClock;
  if (kind == ExplanationKind::kChangeDuringRecord) {
    return MessageCode::kWindowsDisagree;
  }
  return kind == ExplanationKind::kBacklash ? MessageCode::kSticking
                                            : MessageCode::kExplained;
}

std::string Capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] -= 'a' - 'A';
  return text;
}

// Whether a clock that is late by so much changes a response of the output, to
// one input or to all, by more than is worth making.
bool ClockMatters(const Candidates& candidates, int i, int input, double late) {
  for (int j = 0; j < candidates.initial.num_inputs(); ++j) {
    const TransferFunction& element = candidates.initial.element(i, j);
    if (element.IsZero() || (input >= 0 && j != input)) continue;
    const double delay = element.delay() + late;
    if (delay < 0.0) return true;
    const Eigen::VectorXd from = candidates.initial_response.element(i, j);
    const Eigen::VectorXd to =
        TransferFunction(element.numerator(), element.denominator(), delay)
            .StepResponse(candidates.data.sample_time(),
                          static_cast<int>(from.size()));
    if ((to - from).norm() > LeastChange(candidates, i, j) * from.norm()) {
      return true;
    }
  }
  return false;
}

int FirstInput(const ProcessModel& model, int output) {
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (!model.element(output, j).IsZero()) return j;
  }
  return 0;
}

std::string Others(const Candidates& candidates, int i) {
  std::string text;
  for (const TakenExplanation& one :
       candidates.competition->outputs()[i].taken) {
    const Explanation& explanation = one.explanation;
    if (IsHeld(explanation.kind)) continue;
    if (IsClock(explanation.kind) &&
        BelievedDelay(candidates, i,
                      explanation.kind == ExplanationKind::kInputClock
                          ? explanation.index
                          : FirstInput(candidates.initial, i)) != 0.0) {
      continue;
    }
    if (IsClock(explanation.kind)) {
      const bool of_output = explanation.kind == ExplanationKind::kOutputClock;
      const int j =
          of_output ? FirstInput(candidates.initial, i) : explanation.index;
      const double late = candidates.competition->ClockOf(i, j);
      if (!ClockMatters(candidates, i, of_output ? -1 : j, late)) continue;
      absl::StrAppend(
          &text, text.empty() ? "" : " ",
          absl::StrFormat(
              "All dead times of %s are %.2g %s %s, or its time stamps are "
              "wrong by as much. ",
              of_output ? candidates.initial.outputs()[i].name
                        : candidates.initial.inputs()[j].name,
              std::abs(late), candidates.initial.time_unit(),
              late < 0.0 ? "shorter" : "longer"),
          TypeOf(explanation.kind).settled_by);
      continue;
    }
    absl::StrAppend(
        &text, text.empty() ? "" : " ",
        Capitalised(Sentence(candidates.initial, i, explanation)),
        Lasts(explanation)
            ? absl::StrFormat(" and is × %.3g at its end. ",
                              GainAtEnd({explanation}, explanation.index))
            : ". ",
        TypeOf(explanation.kind).settled_by);
  }
  return text;
}

// The elements of output i that another output contradicts, in sentences.
std::string Contested(const ProcessModel& model, const Competition& competition,
                      int i) {
  std::string text;
  for (const TakenExplanation& one : competition.outputs()[i].taken) {
    const Explanation& aged = one.explanation;
    if (!IsHeld(aged.kind)) continue;
    const std::optional<ShownOfInput> shown =
        ContestedBy(competition, i, aged.index);
    if (!shown.has_value()) continue;
    absl::StrAppend(&text, text.empty() ? "" : " ",
                    Capitalised(Sentence(model, i, aged)), ", or ",
                    Sentence(model, shown->output, shown->explanation), ", as ",
                    model.outputs()[shown->output].name, " shows. ",
                    TypeOf(shown->explanation.kind).settled_by);
  }
  return text;
}

// Whether what won for output i misleads a correction of its other elements. A
// reversed sign is a mistake of configuration, which no change of the others
// makes up for. Where a load comes with set points, as this output or another
// shows, set points drive more than the plant.
bool Misleads(const Competition& competition, int i) {
  for (const TakenExplanation& one : competition.outputs()[i].taken) {
    const Explanation& taken = one.explanation;
    if (taken.kind == ExplanationKind::kReversed ||
        taken.kind == ExplanationKind::kLoadWithSetPoints) {
      return true;
    }
    if (!IsHeld(taken.kind)) continue;
    const std::optional<ShownOfInput> shown =
        ContestedBy(competition, i, taken.index);
    if (shown.has_value() &&
        shown->explanation.kind == ExplanationKind::kLoadWithSetPoints) {
      return true;
    }
  }
  return false;
}

std::string Ties(const ProcessModel& model, const OutputExplanation& output,
                 int i) {
  std::string text;
  for (const OutputExplanation::Tie& tie : output.ties) {
    if (!IsAgeing(tie.taken.kind)) continue;
    absl::StrAppend(&text, text.empty() ? "" : " ",
                    "Two explanations account for ", model.outputs()[i].name,
                    " equally well: ", Sentence(model, i, tie.taken), ", or ",
                    Sentence(model, i, tie.rival), ". ",
                    TypeOf(tie.rival.kind).settled_by);
  }
  return text;
}

// The elements that the likelihood proposes to change: fewer of them are a
// simpler explanation than what won.
std::size_t NumProposed(const Candidates& candidates, int i) {
  std::size_t count = 0;
  for (int j = 0; j < candidates.initial.num_inputs(); ++j) {
    if (ProposesElement(candidates.estimate, i, j)) ++count;
  }
  return count;
}

// The largest change that is proposed of an output's responses, relative to
// each.
double LargestChange(const Candidates& candidates, int i) {
  double largest = 0.0;
  const StepResponse& initial = candidates.initial_response;
  for (int j = 0; j < initial.num_inputs; ++j) {
    if (!ProposesElement(candidates.estimate, i, j)) continue;
    const Eigen::VectorXd from = initial.element(i, j);
    const Eigen::VectorXd to =
        candidates.estimate.fit.output_error.corrected.model.element(i, j)
            .StepResponse(initial.sample_time, static_cast<int>(from.size()));
    largest =
        std::max(largest, (to - from).norm() / std::max(from.norm(), 1e-300));
  }
  return largest;
}

std::string ErrorsText(const OutputExplanation& output,
                       const ProcessModel& model, int i) {
  std::string text;
  for (const HorizonErrors& error : output.held_out) {
    absl::StrAppend(
        &text, text.empty() ? "its error " : ", ",
        error.horizon > 0.0
            ? absl::StrFormat("%.3g %s ahead", error.horizon, model.time_unit())
            : "simulated",
        absl::StrFormat(" is %.3g after %.3g", error.explained, error.initial));
  }
  const std::string& unit = model.outputs()[i].unit;
  return text.empty() || unit.empty() || unit == "-"
             ? text
             : absl::StrCat(text, " ", unit);
}

// What is left of the error of free simulation, as a share.
double SimulatedRatio(const OutputExplanation& output) {
  for (const HorizonErrors& error : output.held_out) {
    if (error.horizon == 0.0 && error.initial > 0.0) {
      return error.explained / error.initial;
    }
  }
  return 1.0;
}

// All horizons together, none much worse, one by more than chance.
bool PredictsBetter(const OutputExplanation& output) {
  bool fallen = false;
  std::vector<double> ratios;
  for (const HorizonErrors& error : output.held_out) {
    if (!(error.initial > 0.0)) continue;
    ratios.push_back(error.explained / error.initial);
    fallen = fallen || error.deviations > kFallen;
  }
  return fallen && FallTogether(ratios);
}

}  // namespace

std::string DescribeExplanation(const ProcessModel& model, int output,
                                const Explanation& explanation) {
  const double value = explanation.value;
  if (explanation.kind == ExplanationKind::kGain) {
    return absl::StrFormat("gain of %s × %.3g",
                           PairName(model, output, explanation.index),
                           std::exp(value));
  }
  if (explanation.kind == ExplanationKind::kTimeConstant) {
    return absl::StrFormat("time constant of %s × %.3g",
                           PairName(model, output, explanation.index),
                           std::exp(value));
  }
  return Sentence(model, output, explanation);
}

std::optional<InstrumentEvidence> EvidenceByInstruments(
    const Candidates& candidates, int i) {
  const OutputExplanation& output = candidates.competition->outputs()[i];
  if (!output.judged()) return std::nullopt;
  InstrumentEvidence evidence;
  evidence.by_set_points = output.by_set_points;
  evidence.feedback_p_value = output.feedback_p_value;
  const std::vector<bool> aged = AgedInputs(candidates, i);
  evidence.ageing = std::find(aged.begin(), aged.end(), true) != aged.end();
  evidence.other = Others(candidates, i);
  // Whether all that won can be held by a corrected model.
  bool correctable = true;
  bool any_other = false;
  for (const TakenExplanation& one : output.taken) {
    const ExplanationKind kind = one.explanation.kind;
    if (IsHeld(kind)) continue;
    if (!any_other) evidence.code = CodeOf(kind);
    any_other = true;
    correctable = correctable && IsClock(kind) && evidence.other.empty();
  }
  const std::string contested =
      Contested(candidates.initial, *candidates.competition, i);
  if (!contested.empty()) {
    correctable = false;
    absl::StrAppend(&evidence.other, evidence.other.empty() ? "" : " ",
                    contested);
  }
  const bool misled = Misleads(*candidates.competition, i);
  evidence.ageing = evidence.ageing && !misled;
  evidence.tie = Ties(candidates.initial, output, i);
  evidence.left = output.left();
  if (evidence.ageing) {
    evidence.predicts_better = PredictsBetter(output);
    evidence.another_in_use = static_cast<bool>(candidates.options.in_use);
    evidence.errors = ErrorsText(output, candidates.initial, i);
    evidence.simulated = SimulatedRatio(output);
  }
  if (ProposesChange(candidates.estimate, i) &&
      !ProposesByArx(candidates.estimate, i)) {
    const Competition::Energies energies = candidates.competition->EnergiesOf(
        i, candidates.estimate.fit.output_error.corrected.model);
    const double energy = energies.remaining;
    bool same = true;
    for (int j = 0; j < candidates.initial.num_inputs(); ++j) {
      same = same && aged[j] == ProposesElement(candidates.estimate, i, j);
    }
    const auto evidence_from = [&](double from) {
      return output.EvidenceOf(from - energy, energies.unit);
    };
    // Small changes are not taken on little evidence, nor doubted for it.
    const bool is_small = LargestChange(candidates, i) < kSmall;
    const double most = candidates.options.explain.evidence;
    // Without feedback what is held out is judge enough; inputs that answer
    // disturbances are hardly one.
    const double asked = output.answered() ? kWhereAnswered * most
                         : is_small        ? most
                                           : kLeastEvidence;
    const bool explains =
        output.open_loop() || evidence_from(output.energy) > asked;
    const bool better =
        contested.empty() && evidence_from(output.remaining) > most;
    evidence.allows_proposal =
        explains && !misled && correctable &&
        energy < output.remaining + kAgrees * output.unit;
    evidence.confirms_proposal =
        (explains && !misled && (better || output.taken.empty())) ||
        (evidence.allows_proposal && !output.together &&
         (NumProposed(candidates, i) < output.taken.size() || same ||
          !evidence.tie.empty() || !evidence.predicts_better));
    // Inputs that answer disturbances refute nothing; where none does, hold-out
    // judges.
    evidence.refutes_proposal =
        !output.answered() &&
        ((!output.open_loop() &&
          ((is_small && output.left() < kMuchLeft) ||
           energies.difference > output.required * output.unit)) ||
         output.EvidenceOf(energy - output.remaining, output.unit) >
             kLeastEvidence);
  }
  return evidence;
}

void TakeExplained(const Candidates& candidates, int i, Estimate& estimate) {
  constexpr double kNormal = 1.959963984540054;  // of 95 %
  KeepInitialOutput(i, estimate);
  OutputErrorCorrection& correction = estimate.fit.output_error;
  OutputErrorFit& fit = correction.corrected;
  const int m = fit.model.num_inputs();
  if (fit.covariances[i].rows() != 3 * m) {
    fit.covariances[i] = Eigen::MatrixXd::Zero(3 * m, 3 * m);
  }
  const std::vector<bool> aged = AgedInputs(candidates, i);
  for (int j = 0; j < m; ++j) {
    if (!aged[j]) continue;
    const absl::StatusOr<TransferFunction> element =
        ExplainedElement(candidates, i, j);
    if (!element.ok()) continue;
    ElementValues values = candidates.competition->Explained(i, j);
    values.delay =
        std::max(0.0, values.delay + BelievedDelay(candidates, i, j));
    // A new path begins at nothing.
    ElementValues before = {.gain = 0.0, .time_scale = 0.0, .delay = 0.0};
    bool has_lag = true;
    if (const auto own =
            ElementResponse::Create(candidates.initial.element(i, j));
        own.ok()) {
      before = own->initial_values();
      has_lag = own->has_time_scale();
    }
    const Eigen::Matrix3d covariance = candidates.competition->Covariance(i, j);
    const auto parameter = [&](double initial, double value, int k) {
      const double error =
          value == initial ? 0.0 : std::sqrt(std::max(covariance(k, k), 0.0));
      return ParameterEstimate{.initial = initial,
                               .value = value,
                               .standard_error = error,
                               .lower = value - kNormal * error,
                               .upper = value + kNormal * error};
    };
    ElementEstimate& written = fit.elements[i * m + j];
    written.state = ElementState::kFitted;
    written.gain = parameter(before.gain, values.gain, 0);
    if (has_lag) {
      written.time_scale = parameter(before.time_scale, values.time_scale, 1);
    }
    written.delay = parameter(before.delay, values.delay, 2);
    fit.model.element(i, j) = *element;
    fit.covariances[i].block<3, 3>(3 * j, 3 * j) = covariance;
    correction.aged(i, j) = true;
  }
}

}  // namespace mle
