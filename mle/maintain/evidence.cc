#include "mle/maintain/evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/explained.h"
#include "mle/maintain/stamps.h"

namespace mle {
namespace {

// "A change of a gain by 2.1 % (top ← reflux) to 9 % (…) would have been
// seen.", of the pairs that the records tell something about; empty where they
// tell nothing about any.
std::string Detectable(const CorrectionResult& result) {
  constexpr double kMost = 1.0;  // more is no change of a gain
  const ProcessModel& model = result.initial;
  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  std::string lowest;
  std::string highest;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const double change = DetectableGain(result, i, j);
      if (!(change < kMost)) continue;
      if (change < low) {
        low = change;
        lowest = PairName(model, i, j);
      }
      if (change > high) {
        high = change;
        highest = PairName(model, i, j);
      }
    }
  }
  if (lowest.empty()) return "";
  return lowest == highest
             ? absl::StrFormat(
                   "A change of the gain of %s by %.2g %% would have been "
                   "seen.",
                   lowest, 100.0 * low)
             : absl::StrFormat(
                   "A change of a gain by %.2g %% (%s) to %.2g %% (%s) would "
                   "have been seen.",
                   100.0 * low, lowest, 100.0 * high, highest);
}

bool IsInformed(const PairErrors& pair) {
  return pair.state == PairState::kInformed || pair.state == PairState::kWeak;
}

// Why no gain is determined: the inputs rest, they move together, or what
// they do is too little beside what else moves the outputs. Empty if one is.
std::string WhyUninformed(const CorrectionResult& result) {
  constexpr double kWeak = 0.5;  // InformationOptions::weak
  const PairInformation& information = result.information;
  if (information.pairs.empty() ||
      std::any_of(information.pairs.begin(), information.pairs.end(),
                  IsInformed)) {
    return "";
  }
  const bool moves =
      std::any_of(information.inputs.begin(), information.inputs.end(),
                  [](const InputExcitation& input) { return input.moves > 0; });
  if (!moves) {
    return "The inputs do not move: records with set-point changes, or a step "
           "test, would settle it.";
  }
  double alone = std::numeric_limits<double>::infinity();
  double best = alone;
  std::string pair;
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    for (int j = 0; j < result.initial.num_inputs(); ++j) {
      const PairErrors& errors = information.pair(i, j);
      if (errors.state == PairState::kAbsent) continue;
      alone = std::min(alone, errors.gain / errors.inflation);
      if (pair.empty() || errors.gain < best) {
        best = errors.gain;
        pair = PairName(result.initial, i, j);
      }
    }
  }
  if (alone <= kWeak) {
    return "The inputs move together, so that no gain is determined by itself: "
           "set-point changes that move them one by one, or a step test, would "
           "settle it.";
  }
  return absl::StrFormat(
      "What the inputs do to the outputs is too little, beside all else that "
      "moves these, to determine any gain%s. Larger or more set-point changes, "
      "or a step test, would settle it.",
      std::isfinite(best)
          ? absl::StrFormat(" (that of %s, which is known best, within ± %.0f "
                            "%%)",
                            pair, 196.0 * best)
          : "");
}

// The first pair of an output that a structure which does not explain the
// records cannot be trusted with: its gain would change its sign, or its input
// moves so much together with others that what the structure lacks goes into
// the difference of their gains.
std::string DoubtfulPair(const CorrectionResult& result, int i) {
  constexpr double kTogether = 10.0;  // PairErrors::inflation
  const EstimateFit& fit = result.estimate.fit;
  if (!fit.adequacy.has_value() || fit.adequacy->adequate ||
      ProposesShape(result.estimate, i)) {
    return "";
  }
  for (int j = 0; j < result.initial.num_inputs(); ++j) {
    if (!fit.output_error.aged(i, j)) continue;
    const ParameterEstimate& gain =
        fit.output_error.corrected.element(i, j).gain;
    const bool together = !result.information.pairs.empty() &&
                          result.information.pair(i, j).inflation > kTogether;
    if (together || gain.value * gain.initial < 0.0) {
      return PairName(result.initial, i, j);
    }
  }
  return "";
}

// By Bonferroni's share of the level for each input.
bool DependsOnInputs(const ResidualReport& residuals) {
  return std::any_of(residuals.inputs.begin(), residuals.inputs.end(),
                     [&](const InputCorrelation& input) {
                       return input.p_value *
                                  static_cast<double>(residuals.inputs.size()) <
                              kDiagnosticLevel;
                     });
}

// Whether a time constant or dead time is as far from the model's as it may be.
// A dead time of 0 is nature's bound, not the search's.
bool AtBound(const ElementEstimate& element, const OutputErrorOptions& search) {
  constexpr double kClose = 1e-3;
  const ParameterEstimate& lag = element.time_scale;
  const ParameterEstimate& delay = element.delay;
  const double factor =
      lag.initial > 0.0 ? std::abs(std::log(lag.value / lag.initial)) : 0.0;
  const double longest = std::isfinite(search.max_delay)
                             ? search.max_delay
                             : 2.0 * delay.initial + lag.initial;
  return factor > (1.0 - kClose) * std::log(search.max_time_scale_factor) ||
         (delay.value > delay.initial &&
          delay.value > (1.0 - kClose) * longest);
}

// A message about the first proposed element that does not look like ageing; an
// element that the model does not have has nothing to be compared with.
std::optional<Message> NotAgeing(const CorrectionResult& result, int i) {
  constexpr double kMostOfTimes = 5.0;  // by which dead time and lag change
  const std::string& name = result.initial.outputs()[i].name;
  for (int j = 0; j < result.initial.num_inputs(); ++j) {
    if (!result.estimate.fit.output_error.aged(i, j) ||
        result.initial.element(i, j).IsZero()) {
      continue;
    }
    const std::string pair = PairName(result.initial, i, j);
    const ElementEstimate& element =
        result.estimate.fit.output_error.corrected.element(i, j);
    const double sample_time = result.data.sample_time();
    const double before =
        element.time_scale.initial + element.delay.initial + sample_time;
    const double after =
        element.time_scale.value + element.delay.value + sample_time;
    if (std::abs(std::log(after / before)) > std::log(kMostOfTimes)) {
      return Message{
          MessageCode::kBeyondAgeing,
          name,
          absl::StrFormat(
              "Dead time and time constant of %s would be %.3g together in "
              "place of %.3g, which no ageing does: compare the numbers and "
              "units of this element with the controller's model.",
              pair, after - sample_time, before - sample_time),
          {}};
    }
    if (!ProposesShape(result.estimate, i, j) &&
        AtBound(element, result.estimate.setting.options.output_error)) {
      return Message{
          MessageCode::kAtBound,
          name,
          absl::StrFormat(
              "The time constant or dead time of %s comes to the end of what "
              "is searched: compare the numbers and units of this element with "
              "the controller's model, or let the search go further.",
              pair),
          {"max_time_constant_factor", "max_delay"}};
    }
    if (!result.information.pairs.empty() &&
        result.information.pair(i, j).state == PairState::kNotInformed) {
      return Message{
          MessageCode::kNotExcited,
          name,
          absl::StrFormat(
              "A change of %s is proposed, but by the controller's model "
              "these records do not determine it: a wrong number or unit in "
              "that model, or a disturbance, would look like this. Set-point "
              "changes that move its input by itself would settle it.",
              pair),
          {}};
    }
  }
  return std::nullopt;
}

OutputEvidence EvidenceOf(const CorrectionResult& result, int i) {
  const Validation& validation = result.validation;
  OutputEvidence evidence;
  evidence.name = result.initial.outputs()[i].name;
  evidence.proposed = ProposesChange(result.estimate, i);
  if (evidence.proposed) {
    evidence.doubtful_pair = DoubtfulPair(result, i);
    evidence.not_ageing = NotAgeing(result, i);
    if (!evidence.not_ageing.has_value()) {
      evidence.not_ageing = ExplainedByStamps(result, i);
    }
  }
  const EstimateFit& fit = result.estimate.fit;
  evidence.unnamed =
      fit.change_proposed &&
      fit.output_error.missing_p_values(i) * result.initial.num_outputs() <
          result.options.estimation.output_error.false_alarm_probability;
  evidence.shape_unseen = ProposesShape(result.estimate, i) &&
                          !DependsOnInputs(result.initial_residuals[i]);
  if (!validation.held_out) return evidence;
  evidence.scores = validation.outputs[i];
  if (ProposesShape(result.estimate, i)) {
    evidence.parametric = validation.parametric[i];
  }
  for (const std::vector<OutputScores>& window : validation.windows) {
    evidence.windows.push_back(window[i]);
  }
  return evidence;
}

}  // namespace

std::vector<bool> UnexplainedOutputs(const Estimate& estimate) {
  std::vector<bool> outputs(estimate.setting.arx_outputs.size());
  const EstimateFit& fit = estimate.fit;
  if (!fit.adequacy.has_value()) return outputs;
  outputs = WrongOutputs(*fit.adequacy, estimate.setting.options.TestLevel());
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    outputs[i] = outputs[i] && !ProposesShape(estimate, static_cast<int>(i));
  }
  return outputs;
}

Evidence GatherEvidence(const CorrectionResult& result,
                        const std::vector<bool>& unexplained,
                        const Competition* competition) {
  Evidence evidence;
  evidence.change_proved = result.estimate.fit.change_proposed;
  evidence.p_value = result.estimate.fit.PValue();
  evidence.nothing_held_out = result.validation.missing;
  evidence.obstacles = result.data.obstacles;
  evidence.uninformed = WhyUninformed(result);
  if (result.options.examine) evidence.detectable = Detectable(result);
  std::vector<bool> undecidable(result.initial.num_outputs());
  for (const Finding& finding : result.data.findings) {
    if (finding.consequence != Consequence::kDoubts) continue;
    evidence.doubts.push_back(finding.message);
    for (const int i : finding.outputs) undecidable[i] = true;
  }
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    evidence.outputs.push_back(EvidenceOf(result, i));
    evidence.outputs[i].undecidable = undecidable[i];
    OutputEvidence& output = evidence.outputs.back();
    if (competition != nullptr) {
      output.instruments = EvidenceByInstruments(result, *competition, i);
    }
    if (!output.instruments.has_value()) {
      output.unexplained = unexplained[i] && !IsAveraged(result, i);
    }
  }
  return evidence;
}

}  // namespace mle
