#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"
#include "mle/model/element_response.h"

namespace mle::correct {
namespace {

using report::FormatSignificant;

// Ratios beyond which a factor reads better than a percentage.
constexpr double kReadablePercent = 2.0;

// "fell by 36 %", "is 3.1 times as large".
std::string DescribeRatio(double ratio) {
  if (ratio > kReadablePercent) {
    return absl::StrCat("is ", FormatSignificant(ratio, 2), " times as large");
  }
  return absl::StrCat(ratio < 1.0 ? "fell by " : "rose by ",
                      FormatSignificant(100.0 * std::abs(ratio - 1.0), 2),
                      " %");
}

// A parameter of an element, said by itself.
enum class Part { kGain, kTimeScale, kDelay };

std::string DescribePart(const ElementEstimate& element, Part part,
                         const std::string& pair,
                         const std::string& time_unit) {
  if (part == Part::kGain) {
    const double ratio = element.gain.value / element.gain.initial;
    return absl::StrCat("Gain of ", pair, " ",
                        ratio < 0.0 ? "has the other sign in the records"
                                    : DescribeRatio(ratio));
  }
  if (part == Part::kTimeScale) {
    return absl::StrCat(
        "Time constant of ", pair, " ",
        DescribeRatio(element.time_scale.value / element.time_scale.initial));
  }
  const double shift = element.delay.value - element.delay.initial;
  return absl::StrCat("Dead time of ", pair, " is ",
                      FormatSignificant(std::abs(shift), 2), " ", time_unit,
                      shift < 0.0 ? " shorter" : " longer");
}

// Names the parameter that by itself makes most of the response's change. Where
// none that has significantly changed makes half of it, names the initial
// slope, K/T, which short records tell even if they do not tell K from T;
// without a lag, or with another sign of the gain, only that the response
// changed.
std::string DescribeElement(const Result& result, int i, int j,
                            const std::string& pair) {
  const ElementEstimate& element =
      result.estimate.fit.output_error.corrected.element(i, j);
  const absl::StatusOr<ElementResponse> response =
      ElementResponse::Create(result.initial.element(i, j));
  if (!response.ok()) return absl::StrCat("Response of ", pair, " changed");
  const StepResponse& initial = result.initial_response;
  const Eigen::VectorXd from = initial.element(i, j);
  const auto change = [&](const ElementValues& values) {
    return (response->ToTransferFunction(values).StepResponse(
                initial.sample_time, static_cast<int>(from.size())) -
            from)
        .norm();
  };
  const ElementValues before = response->initial_values();
  const ElementValues after = element.values();
  const double all = change(after);
  double most = 0.0;
  Part carries = Part::kGain;
  const auto compare = [&](Part part, const ParameterEstimate& parameter,
                           double ElementValues::*value) {
    if (!HasMoved(parameter)) return;
    ElementValues alone = before;
    alone.*value = after.*value;
    const double by_itself = change(alone);
    if (by_itself > most) {
      most = by_itself;
      carries = part;
    }
  };
  if (element.gain.initial != 0.0) {
    compare(Part::kGain, element.gain, &ElementValues::gain);
  }
  compare(Part::kTimeScale, element.time_scale, &ElementValues::time_scale);
  compare(Part::kDelay, element.delay, &ElementValues::delay);
  if (most > 0.5 * all) {
    return DescribePart(element, carries, pair, result.initial.time_unit());
  }
  if (response->has_time_scale() && before.gain * after.gain > 0.0) {
    const double ratio =
        (after.gain / after.time_scale) / (before.gain / before.time_scale);
    return absl::StrCat("Initial slope (gain by time constant) of ", pair, " ",
                        DescribeRatio(ratio));
  }
  return absl::StrCat("Response of ", pair, " changed");
}

std::string DescribePairChange(const Result& result, int output, int input) {
  const std::string pair = PairName(result.initial, output, input);
  if (HasOtherShape(result, output, input)) {
    return result.initial.element(output, input).IsZero()
               ? absl::StrCat(pair, " is a new path")
               : absl::StrCat("Response of ", pair, " has another shape");
  }
  if (result.corrected.process.has_value()) {
    return DescribeElement(result, output, input, pair);
  }
  return absl::StrCat(
      "Response of ", pair, " changed by ",
      FormatSignificant(100.0 * result.change.elements(output, input), 2),
      " %");
}

// "C ← D and E ← F", "C ← D, E ← F and 3 more": those after the first.
std::string OtherPairs(const Result& result,
                       const std::vector<ElementChange>& changes) {
  constexpr std::size_t kNamed = 2;
  std::vector<std::string> names;
  for (std::size_t k = 1; k < changes.size() && names.size() < kNamed; ++k) {
    names.push_back(
        PairName(result.initial, changes[k].output, changes[k].input));
  }
  const std::size_t more = changes.size() - 1 - names.size();
  if (more > 0) {
    return absl::StrCat(absl::StrJoin(names, ", "), " and ", more, " more");
  }
  return absl::StrJoin(names, " and ");
}

std::string Counted(std::size_t count, const char* one, const char* many) {
  return absl::StrCat(count, " ", count == 1 ? one : many);
}

// Without its full stop.
std::string_view FirstSentence(std::string_view text) {
  const std::size_t end = text.find(". ");
  if (end != std::string_view::npos) return text.substr(0, end);
  if (text.ends_with('.')) text.remove_suffix(1);
  return text;
}

}  // namespace

const Message* Mistake(const Result& result) {
  for (const Message& obstacle : result.data.obstacles) {
    if (obstacle.code == MessageCode::kMistake) return &obstacle;
  }
  return nullptr;
}

std::vector<ElementChange> ElementChanges(const Result& result) {
  std::vector<ElementChange> changes;
  if (result.decision != Decision::kCorrected) return changes;
  for (const auto& [i, j] : Pairs(result.initial)) {
    if (!HasChanged(result, i, j)) continue;
    changes.push_back(
        {i, j, result.change.elements(i, j), DescribePairChange(result, i, j)});
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const ElementChange& a, const ElementChange& b) {
                     return a.size > b.size;
                   });
  return changes;
}

std::string Headline(const Result& result) {
  if (!result.failures.empty()) return "The result is not usable";
  switch (result.decision) {
    case Decision::kNoChange:
      return "The controller's model still describes the plant";
    case Decision::kCannotTell:
      if (const Message* mistake = Mistake(result)) {
        return std::string(FirstSentence(mistake->text));
      }
      return "Whether the model has aged cannot be told from these records";
    case Decision::kCorrected:
      break;
  }
  const std::vector<ElementChange> changes = ElementChanges(result);
  if (!result.curves.empty()) {
    std::string curve = DescribeCurve(result.initial, result.curves.front());
    for (std::size_t k = 1; k < result.curves.size(); ++k) {
      const FoundCurve& other = result.curves[k];
      absl::StrAppend(&curve, k == 1 ? "; curved too: " : ", ",
                      other.is_output
                          ? result.initial.outputs()[other.channel].name
                          : result.initial.inputs()[other.channel].name);
    }
    return changes.empty() ? curve
                           : absl::StrCat(curve, "; also: ", changes[0].text);
  }
  if (changes.empty()) return "The model has changed";
  if (changes.size() == 1) return changes[0].text;
  return absl::StrCat(changes[0].text, "; also ", OtherPairs(result, changes),
                      " changed");
}

std::string SignNote(const Result& result) {
  if (!result.accepted() || !result.corrected.process.has_value()) return "";
  for (const ElementChange& change : ElementChanges(result)) {
    const ParameterEstimate& gain = result.estimate.fit.output_error.corrected
                                        .element(change.output, change.input)
                                        .gain;
    if (!HasMoved(gain) || !(gain.value * gain.initial < 0.0)) continue;
    return absl::StrCat(
        "A change of sign is unlikely to be ageing: check the sign of ",
        PairName(result.initial, change.output, change.input),
        " in the controller's model and in its tags.");
  }
  return "";
}

std::string Instruction(const Result& result) {
  if (!result.failures.empty()) {
    return "Keep the controller's model: a fit is not certified.";
  }
  switch (result.decision) {
    case Decision::kNoChange:
      return "Keep the controller's model.";
    case Decision::kCannotTell:
      return Mistake(result) != nullptr
                 ? "Keep the controller's model for now: correct this and run "
                   "again."
                 : "Keep the controller's model for now.";
    case Decision::kCorrected:
      return "Use the corrected model in the controller.";
  }
  return "";
}

std::string ReasonBesideHeadline(const Result& result) {
  if (result.decision == Decision::kCorrected) return "";
  const Message* const mistake = Mistake(result);
  if (mistake == nullptr) return MainReason(result);
  std::string_view rest = mistake->text;
  rest.remove_prefix(FirstSentence(rest).size());
  rest.remove_prefix(std::min(rest.find_first_not_of(". "), rest.size()));
  return std::string(rest);
}

std::vector<std::string> ShortVerdict(const Result& result) {
  std::vector<std::string> lines = {Instruction(result),
                                    absl::StrCat(Headline(result), ".")};
  for (std::string line : {ReasonBesideHeadline(result), SignNote(result)}) {
    if (!line.empty()) lines.push_back(std::move(line));
  }
  if (std::string worth = WhatItIsWorth(result); !worth.empty()) {
    lines.push_back(std::move(worth));
  }
  for (const Message& message : result.request.left_out) {
    lines.push_back(message.text);
  }
  return lines;
}

std::string WhereTheRestIs(const Result& result) {
  std::string more;
  if (!result.warnings.empty()) {
    more = absl::StrCat(" (",
                        Counted(result.warnings.size(), "warning", "warnings"),
                        "; --verbose shows all)");
  }
  return absl::StrCat("Report: ", result.request.out, "/report.html", more);
}

}  // namespace mle::correct
