#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"
#include "mle/base/double_limits.h"

namespace mle::correct {
namespace {

using report::FormatFixed;
using report::FormatProbability;
using report::FormatSignificant;

std::string PercentInWords(double value) {
  return std::isfinite(value) ? absl::StrCat(FormatFixed(value, 1), " %")
                              : "unknown";
}

// A change of a step response counts above this share of its size, where no
// structure was fitted to judge it by.
constexpr double kNoticedChange = 0.05;

double HalfWidth(const ParameterEstimate& estimate) {
  return 0.5 * (estimate.upper - estimate.lower);
}

std::string WithHalfWidth(const ParameterEstimate& estimate) {
  return absl::StrCat(FormatSignificant(estimate.value), " ± ",
                      report::FormatHalfWidth(HalfWidth(estimate)));
}

// How closely the records confirm the gains, and which they do not.
std::string Confirmation(const Result& result) {
  constexpr double kDetectable = 0.5;  // a change of the gain by half
  const OutputErrorFit& full = result.estimate.fit.output_error.full;
  const ProcessModel& model = result.initial;
  double largest = 0.0;
  int confirmed = 0;
  std::vector<std::string> unknown;
  for (const auto& [i, j] : Pairs(model)) {
    const ElementEstimate& element = full.element(i, j);
    const PairState state = result.information.pair(i, j).state;
    if (state == PairState::kAbsent) continue;
    if (state != PairState::kInformed) {
      if (DetectableGain(result, i, j) < kDetectable) continue;
      unknown.push_back(PairName(model, i, j));
      continue;
    }
    ++confirmed;
    largest =
        std::max(largest, HalfWidth(element.gain) /
                              std::max(std::abs(element.gain.initial), 1e-300));
  }
  std::string text;
  if (confirmed > 0) {
    text = absl::StrCat(
        unknown.empty()
            ? "They determine every gain within ± "
            : absl::StrCat("They determine ", confirmed, " gains within ± "),
        FormatSignificant(100.0 * largest, 2), " % (",
        absl::StrFormat(
            "%.4g", 100.0 * result.options.estimation.output_error.confidence),
        " % intervals)");
  }
  if (!unknown.empty()) {
    absl::StrAppend(&text, text.empty() ? "They" : ", but",
                    " contain little or no information about ",
                    absl::StrJoin(unknown, ", "));
  }
  return text.empty() ? text : text + ".";
}

// "; 3 of 7 elements have changed, overhead ← reflux most (36 % of its
// response)".
std::string WhereMost(const Result& result) {
  const ProcessModel& model = result.initial;
  int present = 0;
  int changed = 0;
  double largest = -1.0;
  std::string most;
  for (const auto& [i, j] : Pairs(model)) {
    if (result.information.pair(i, j).state != PairState::kAbsent ||
        HasOtherShape(result, i, j)) {
      ++present;
    }
    if (!HasChanged(result, i, j)) continue;
    ++changed;
    if (!(result.change.elements(i, j) > largest)) continue;
    largest = result.change.elements(i, j);
    most = PairName(model, i, j);
  }
  if (changed == 0) return "";
  return absl::StrCat("; ", changed, " of ", present,
                      present == 1 ? " element has" : " elements have",
                      " changed, ", most, changed > 1 ? " most (" : " (",
                      FormatSignificant(100.0 * largest, 2),
                      " % of its step response)");
}

std::string WhatToDo(const Result& result) {
  const double p_value = PValue(result);
  const std::string p =
      p_value < 1e-300 ? "p < 10⁻³⁰⁰" : "p = " + FormatProbability(p_value);
  switch (result.decision) {
    case Decision::kNoChange:
      return absl::StrCat("Keep the controller's model. ", MainReason(result));
    case Decision::kCorrected:
      return absl::StrCat("Use the corrected model in the controller: ",
                          result.curves.empty()
                              ? "the model has aged"
                              : "its gains depend on the operating point",
                          " (", p, " for no change)", WhereMost(result), ".");
    case Decision::kCannotTell:
      return absl::StrCat(
          "Keep the controller's model for now: whether it has aged cannot be "
          "told. ",
          MainReason(result));
  }
  return "";
}

bool HasScores(const OutputScores& output) {
  return !std::isnan(output.several_steps.corrected);
}

// "11 to 84 %", of what `fit_of` gives for each output.
template <typename Function>
std::string RangeOfFits(const std::vector<OutputScores>& outputs,
                        const Function& fit_of) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const OutputScores& output : outputs) {
    if (!HasScores(output)) continue;
    low = std::min(low, fit_of(output.several_steps));
    high = std::max(high, fit_of(output.several_steps));
  }
  if (!std::isfinite(low) || !std::isfinite(high)) return "unknown";
  const std::string from = FormatFixed(low, 0);
  const std::string to = FormatFixed(high, 0);
  return from == to ? absl::StrCat(to, " %")
                    : absl::StrCat(from, " to ", to, " %");
}

// "gain 12.8 → 6.40 ± 0.02 (× 0.50), dead time + 0.1 ± 0.2 min".
std::string DescribeChange(const ElementEstimate& element,
                           const std::string& time_unit) {
  std::vector<std::string> moved;
  std::vector<std::string> stayed;
  const auto add = [&](const ParameterEstimate& estimate, const char* name,
                       const std::string& change) {
    if (HasMoved(estimate)) {
      moved.push_back(absl::StrCat(name, " ",
                                   FormatSignificant(estimate.initial), " → ",
                                   WithHalfWidth(estimate), change));
    } else {
      stayed.push_back(name);
    }
  };
  add(element.gain, "gain",
      element.gain.initial != 0.0
          ? absl::StrCat(
                " (× ",
                FormatSignificant(element.gain.value / element.gain.initial),
                ")")
          : "");
  const bool has_lag = element.time_scale.initial > 0.0;
  if (has_lag) {
    add(element.time_scale, "time constant",
        absl::StrCat(" ", time_unit, " (× ",
                     FormatSignificant(element.time_scale.value /
                                       element.time_scale.initial),
                     ")"));
  }
  const double shift = element.delay.value - element.delay.initial;
  add(element.delay, "dead time",
      absl::StrCat(" ", time_unit, " (", shift < 0.0 ? "−" : "+",
                   FormatSignificant(std::abs(shift)), " ", time_unit, ")"));
  if (moved.empty()) {
    return absl::StrCat("gain", has_lag ? ", time constant" : "",
                        " and dead time differ jointly, but none significantly "
                        "by itself");
  }
  std::string text = absl::StrJoin(moved, ", ");
  if (!stayed.empty()) {
    absl::StrAppend(&text, "; ", absl::StrJoin(stayed, " and "),
                    " not significantly changed");
  }
  return text;
}

// Every parameter of an element, the sentence with the first.
void AddElement(const ElementEstimate& element, const std::string& pair,
                const std::string& time_unit, std::vector<Finding>& findings) {
  const auto add = [&](const char* name, const std::string& unit,
                       const ParameterEstimate& estimate) {
    findings.push_back(
        {name, pair, estimate.value, unit, estimate.lower, estimate.upper, ""});
  };
  const std::size_t first = findings.size();
  add("gain", "", element.gain);
  add("time_constant", time_unit, element.time_scale);
  add("delay", time_unit, element.delay);
  findings[first].text =
      absl::StrCat(pair, ": ", DescribeChange(element, time_unit), ".");
}

void AddChangedElements(const Result& result, std::vector<Finding>& findings) {
  const ProcessModel& model = result.initial;
  const OutputErrorCorrection& output_error = result.estimate.fit.output_error;
  for (const auto& [i, j] : Pairs(model)) {
    if (!HasChanged(result, i, j)) continue;
    const std::string pair = PairName(model, i, j);
    if (result.corrected.process.has_value()) {
      AddElement(output_error.corrected.element(i, j), pair, model.time_unit(),
                 findings);
      continue;
    }
    const double change = 100.0 * result.change.elements(i, j);
    findings.push_back({"response_change", pair, change, "%", kNaN, kNaN,
                        absl::StrCat(pair, ": the step response changes by ",
                                     PercentInWords(change), " of its size.")});
  }
}

// Where the correction has another shape.
void AddShapes(const Result& result, std::vector<Finding>& findings) {
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    for (int j = 0; j < result.initial.num_inputs(); ++j) {
      if (!HasOtherShape(result, i, j)) continue;
      const std::string pair = PairName(result.initial, i, j);
      findings.push_back(
          {"other_shape", pair, kNaN, "", kNaN, kNaN,
           absl::StrCat(pair, result.initial.element(i, j).IsZero()
                                  ? ": a path that the model did not have."
                                  : ": the response has another shape.")});
    }
  }
}

void AddFits(const Result& result, std::vector<Finding>& findings) {
  const Validation& validation = result.validation;
  const std::size_t first = findings.size();
  std::vector<std::string> parts;
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    const OutputScores& output = validation.outputs[i];
    if (!HasScores(output)) continue;
    const std::string& name = result.initial.outputs()[i].name;
    parts.push_back(absl::StrCat(
        name, " ", PercentInWords(output.several_steps.corrected), " (",
        PercentInWords(output.several_steps.initial), "), simulated ",
        PercentInWords(output.simulated.corrected), " (",
        PercentInWords(output.simulated.initial), ")"));
    findings.push_back({"fit_several_steps", name,
                        output.several_steps.corrected, "%", kNaN, kNaN, ""});
    findings.push_back({"fit_simulated", name, output.simulated.corrected, "%",
                        kNaN, kNaN, ""});
  }
  if (parts.empty()) return;
  findings[first].text = absl::StrCat(
      "Fit on parts of windows held out, ", Ahead(result),
      ", corrected (controller's model): ", absl::StrJoin(parts, "; "), ".");
}

}  // namespace

bool HasChanged(const Result& result, int output, int input) {
  return result.corrected.process.has_value()
             ? result.estimate.fit.output_error.aged(output, input)
             : result.change.elements(output, input) > kNoticedChange;
}

std::string MainReason(const Result& result) {
  for (const Message& reason : result.reasons) {
    if (reason.code != MessageCode::kChangeProved) return reason.text;
  }
  return "";
}

std::string Ahead(const Result& result) {
  return absl::StrCat(absl::StrFormat("%.3g", result.validation.horizon *
                                                  result.data.sample_time()),
                      " ", result.initial.time_unit(), " ahead");
}

std::string WhatItIsWorth(const Result& result) {
  if (!result.failures.empty()) {
    return "The result is not usable because a fit is not certified; see the "
           "warnings.";
  }
  if (result.decision == Decision::kNoChange) return Confirmation(result);
  if (!result.validation.held_out) return "";
  const std::vector<OutputScores>& outputs = result.validation.outputs;
  std::vector<std::string> sentences;
  if (std::any_of(outputs.begin(), outputs.end(), HasScores)) {
    sentences.push_back(absl::StrCat(
        "On held-out data the correction has a fit of ",
        RangeOfFits(outputs, [](const auto& o) { return o.corrected; }), ", ",
        Ahead(result), ", the controller's model ",
        RangeOfFits(outputs, [](const auto& o) { return o.initial; }), "."));
  }
  // Of what the likelihood did not propose.
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    if (result.accepted_outputs[i] != Acceptance::kExplained) continue;
    for (const Message& reason : result.reasons) {
      if (reason.code == MessageCode::kPredictsBetter &&
          reason.place == result.initial.outputs()[i].name) {
        sentences.push_back(reason.text);
      }
    }
  }
  return absl::StrJoin(sentences, " ");
}

bool HasMoved(const ParameterEstimate& estimate) {
  return estimate.initial < estimate.lower || estimate.initial > estimate.upper;
}

std::vector<std::string> DescribeVerdict(const Result& result) {
  std::vector<std::string> sentences = {WhatToDo(result)};
  if (std::string worth = WhatItIsWorth(result); !worth.empty()) {
    sentences.push_back(std::move(worth));
  }
  return sentences;
}

std::vector<std::string> Sentences(const std::vector<Finding>& findings) {
  std::vector<std::string> sentences;
  for (const Finding& finding : findings) {
    if (!finding.text.empty()) sentences.push_back(finding.text);
  }
  return sentences;
}

std::vector<Finding> Findings(const Result& result) {
  std::vector<Finding> findings;
  AddShapes(result, findings);
  if (result.decision == Decision::kCorrected) {
    AddChangedElements(result, findings);
    const double relative = 100.0 * result.change.relative;
    findings.push_back(
        {"response_change", "", relative, "%", kNaN, kNaN,
         absl::StrCat("The step responses change by ", PercentInWords(relative),
                      " of their norm (E = ",
                      FormatSignificant(result.change.total), ").")});
  }
  if (result.validation.held_out) {
    AddFits(result, findings);
  }
  if (result.initial_to_truth.has_value()) {
    findings.push_back(
        {"truth_E_corrected", "", result.corrected_to_truth->total, "", kNaN,
         kNaN,
         absl::StrCat("Against the given truth, E is ",
                      FormatSignificant(result.initial_to_truth->total, 4),
                      " for the controller's model and ",
                      FormatSignificant(result.corrected_to_truth->total, 4),
                      " for the model written.")});
  }
  return findings;
}

std::string Details(const Result& result) {
  std::string text;
  for (const std::string& sentence : result.verdict) {
    absl::StrAppend(&text, sentence, "\n");
  }
  for (const std::string& sentence : Sentences(result.findings)) {
    absl::StrAppend(&text, "  ", sentence, "\n");
  }
  absl::StrAppend(&text, "\n", IntervalNote(result), "\n");
  for (const report::Table& table :
       {MismatchTable(result), ParameterTable(result), ValidationTable(result),
        ResidualTable(result)}) {
    absl::StrAppend(&text, "\n", report::RenderText(table));
  }
  absl::StrAppend(&text, "\nWhat to do\n");
  for (const std::string& item : result.advice) {
    absl::StrAppend(&text, "  ", item, "\n");
  }
  if (result.tuning.heading.empty()) return text;
  absl::StrAppend(&text, "\n", result.tuning.heading, "\n");
  for (const std::string& reason : result.tuning.reasons) {
    absl::StrAppend(&text, "  ", reason, "\n");
  }
  return text;
}

}  // namespace mle::correct
