#include "mle/maintain/evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/maintain/explained.h"

namespace mle {
namespace {

// "A change of a gain by 2.1 % (top ← reflux) to 9 % (…) would have been
// seen.", of the pairs that the records tell something about; empty where they
// tell nothing about any.
std::string Detectable(const Candidates& candidates) {
  constexpr double kMost = 1.0;  // more is no change of a gain
  const ProcessModel& model = candidates.initial;
  const std::vector<OutputExplanation> explanations =
      candidates.competition.has_value() ? candidates.competition->outputs()
                                         : std::vector<OutputExplanation>();
  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  std::string lowest;
  std::string highest;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const double change =
          DetectableGain(explanations, candidates.estimate, i, j);
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
std::string WhyUninformed(const Candidates& candidates) {
  constexpr double kWeak = 0.5;  // InformationOptions::weak
  const PairInformation& information = candidates.information;
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
  for (int i = 0; i < candidates.initial.num_outputs(); ++i) {
    for (int j = 0; j < candidates.initial.num_inputs(); ++j) {
      const PairErrors& errors = information.pair(i, j);
      if (errors.state == PairState::kAbsent) continue;
      alone = std::min(alone, errors.gain / errors.inflation);
      if (pair.empty() || errors.gain < best) {
        best = errors.gain;
        pair = PairName(candidates.initial, i, j);
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

OutputEvidence EvidenceOf(const Candidates& candidates,
                          const Validation& validation, int i) {
  OutputEvidence evidence;
  evidence.name = candidates.initial.outputs()[i].name;
  evidence.proposed = ProposesChange(candidates.estimate, i);
  if (!validation.held_out) return evidence;
  evidence.scores = validation.outputs[i];
  for (const std::vector<OutputScores>& window : validation.windows) {
    evidence.windows.push_back(window[i]);
  }
  return evidence;
}

}  // namespace

Evidence GatherEvidence(const Candidates& candidates,
                        const Validation& validation) {
  Evidence evidence;
  evidence.change_proved = candidates.estimate.fit.change_proposed;
  evidence.p_value = candidates.estimate.fit.test.p_value;
  evidence.nothing_held_out = validation.missing;
  evidence.obstacles = candidates.data.obstacles;
  evidence.uninformed = WhyUninformed(candidates);
  if (candidates.options.examine) evidence.detectable = Detectable(candidates);
  std::vector<bool> undecidable(candidates.initial.num_outputs());
  for (const Finding& finding : candidates.data.findings) {
    if (finding.consequence != Consequence::kDoubts) continue;
    evidence.doubts.push_back(finding.message);
    for (const int i : finding.outputs) undecidable[i] = true;
  }
  for (int i = 0; i < candidates.initial.num_outputs(); ++i) {
    evidence.outputs.push_back(EvidenceOf(candidates, validation, i));
    evidence.outputs[i].undecidable = undecidable[i];
    OutputEvidence& output = evidence.outputs.back();
    if (candidates.competition.has_value()) {
      output.instruments = EvidenceByInstruments(candidates, i);
    }
  }
  return evidence;
}

}  // namespace mle
