#include "mle/maintain/explained.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/maintain/aged_elements.h"
#include "mle/maintain/explained_text.h"
#include "mle/maintain/stamps.h"
#include "mle/model/element_response.h"
#include "mle/nonlinear/distributions.h"

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

MessageCode CodeOf(ExplanationKind kind) {
  if (IsClock(kind)) return MessageCode::kClock;
  if (kind == ExplanationKind::kChangeDuringRecord) {
    return MessageCode::kWindowsDisagree;
  }
  return kind == ExplanationKind::kBacklash ? MessageCode::kSticking
                                            : MessageCode::kExplained;
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

// What is left of the error of free simulation, as a share.
double SimulatedRatio(const OutputExplanation& output) {
  for (const HorizonErrors& error : output.held_out) {
    if (error.horizon == 0.0 && error.initial > 0.0) {
      return error.explained / error.initial;
    }
  }
  return 1.0;
}

}  // namespace

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
                               .lower = value - kNormalQuantile * error,
                               .upper = value + kNormalQuantile * error};
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
