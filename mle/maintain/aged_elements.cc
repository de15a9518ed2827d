#include "mle/maintain/aged_elements.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "Eigen/Core"
#include "mle/maintain/stamps.h"
#include "mle/model/element_response.h"

namespace mle {
namespace {

// Whether what won changes the element's response by more than is worth making;
// a new one's, relative to the largest of its output.
bool IsWorthMaking(const Candidates& candidates, int i, int j) {
  const absl::StatusOr<TransferFunction> element =
      ExplainedElement(candidates, i, j);
  if (!element.ok()) return false;
  const StepResponse& initial = candidates.initial_response;
  const Eigen::VectorXd from = initial.element(i, j);
  double norm = from.norm();
  for (int k = 0; norm == 0.0 && k < initial.num_inputs; ++k) {
    norm = std::max(norm, initial.element(i, k).norm());
  }
  const Eigen::VectorXd to = element->StepResponse(
      candidates.data.sample_time(), static_cast<int>(from.size()));
  return (to - from).norm() > LeastChange(candidates, i, j) * norm;
}

}  // namespace

absl::StatusOr<TransferFunction> ExplainedElement(const Candidates& candidates,
                                                  int i, int j) {
  ElementValues values = candidates.competition->Explained(i, j);
  values.delay = std::max(0.0, values.delay + BelievedDelay(candidates, i, j));
  return candidates.competition->ElementOf(i, j, values);
}

double BelievedDelay(const Candidates& candidates, int i, int j) {
  const double clock = candidates.competition->ClockOf(i, j);
  return std::abs(clock) > MostOfClock(candidates, i) ? clock : 0.0;
}

bool IsClock(ExplanationKind kind) {
  return kind == ExplanationKind::kOutputClock ||
         kind == ExplanationKind::kInputClock;
}

bool Lasts(const Explanation& explanation) {
  return explanation.kind == ExplanationKind::kChangeDuringRecord &&
         ShareOfChange(explanation.part, 1.0) > 0.0 &&
         GainAtEnd({explanation}, explanation.index) > 0.0;
}

std::optional<ShownOfInput> ContestedBy(const Competition& competition, int i,
                                        int j) {
  std::optional<ShownOfInput> shown;
  const std::vector<OutputExplanation>& outputs = competition.outputs();
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    for (const TakenExplanation& one : outputs[o].taken) {
      const Explanation& explanation = one.explanation;
      if (TypeOf(explanation.kind).place != ExplanationPlace::kInput ||
          IsClock(explanation.kind) || explanation.index != j) {
        continue;
      }
      if (static_cast<int>(o) == i) return std::nullopt;
      if (!shown.has_value()) shown = {static_cast<int>(o), explanation};
    }
  }
  return shown;
}

std::vector<bool> AgedInputs(const Candidates& candidates, int i) {
  const ProcessModel& model = candidates.initial;
  std::vector<bool> aged(model.num_inputs(), false);
  const OutputExplanation& output = candidates.competition->outputs()[i];
  const std::vector<TakenExplanation>& taken = output.taken;
  for (int j = 0; j < model.num_inputs(); ++j) {
    for (const TakenExplanation& one : taken) {
      if (IsHeld(one.explanation.kind) && one.explanation.index == j) {
        aged[j] = true;
      }
    }
    if (BelievedDelay(candidates, i, j) != 0.0 &&
        !model.element(i, j).IsZero()) {
      aged[j] = true;
    }
    // Of a gain that changed during the record its value at the end holds, if
    // nothing else explains it as well: a load's step, a curve. Of one that
    // changed for a time the records do not say what holds.
    for (const TakenExplanation& one : taken) {
      if (one.explanation.kind == ExplanationKind::kChangeDuringRecord &&
          one.explanation.index == j) {
        aged[j] = Lasts(one.explanation) && !output.HasTie(one.explanation) &&
                  ProposesElement(candidates.estimate, i, j);
      }
    }
    if (ContestedBy(*candidates.competition, i, j).has_value()) aged[j] = false;
    // Inputs may answer what disturbs the output once, which no test of
    // feedback sees: the likelihood has to propose the element, too, if it is
    // one of the model's.
    if (!output.by_set_points && !output.together &&
        !model.element(i, j).IsZero() &&
        !ProposesElement(candidates.estimate, i, j)) {
      aged[j] = false;
    }
  }
  // Nor is a change made that is not worth making; of elements that were fitted
  // together one is enough.
  std::vector<bool> worth(aged.size(), false);
  for (int j = 0; j < model.num_inputs(); ++j) {
    worth[j] = aged[j] && IsWorthMaking(candidates, i, j);
  }
  const bool any = std::find(worth.begin(), worth.end(), true) != worth.end();
  return output.together && any ? aged : worth;
}

}  // namespace mle
