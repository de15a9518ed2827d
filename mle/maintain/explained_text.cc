#include "mle/maintain/explained_text.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/maintain/aged_elements.h"
#include "mle/maintain/explained.h"
#include "mle/maintain/stamps.h"
#include "mle/model/element_response.h"

namespace mle {
namespace {

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

// ": T = 9.8 min upwards and 15 min downwards …", of a response that has two
// time constants; what a controller that holds one is given is their geometric
// mean, which is as far from either.
std::string BothTimes(const Candidates& candidates, int i,
                      const Explanation& explanation) {
  if (explanation.kind != ExplanationKind::kDirection) return "";
  const double up =
      candidates.competition->Explained(i, explanation.index).time_scale;
  const double down = up * std::exp(explanation.value);
  const std::string& unit = candidates.initial.time_unit();
  return absl::StrFormat(
      ", with a time constant of %.3g %s where it rises and %.3g %s where it "
      "falls (a controller that holds one takes %.3g %s, their geometric mean)",
      up, unit, down, unit, std::sqrt(up * down), unit);
}

}  // namespace

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
        BothTimes(candidates, i, explanation),
        Lasts(explanation)
            ? absl::StrFormat(" and is × %.3g at its end. ",
                              GainAtEnd({explanation}, explanation.index))
            : ". ",
        TypeOf(explanation.kind).settled_by);
  }
  return text;
}

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

}  // namespace mle
