#include "mle/maintain/withdrawal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/maintain/corrected_model.h"
#include "mle/maintain/shared_delays.h"

namespace mle {
namespace {

void WithdrawSmallChanges(const StepResponse& proposed,
                          CorrectionResult& result) {
  Estimate& estimate = result.estimate;
  const StepResponse& initial = result.initial_response;
  for (int i = 0; i < initial.num_outputs; ++i) {
    double largest = 0.0;
    for (int j = 0; j < initial.num_inputs; ++j) {
      largest = std::max(largest, initial.element(i, j).norm());
    }
    bool any = false;
    for (int j = 0; j < initial.num_inputs; ++j) {
      const double norm = initial.element(i, j).norm();
      const double change =
          (proposed.element(i, j) - initial.element(i, j)).norm();
      const bool small = change <= result.options.decision.least_change *
                                       (norm > 0.0 ? norm : largest);
      any = any || !small;
      if (small && ProposesElement(estimate, i, j) &&
          !ProposesByArx(estimate, i)) {
        KeepInitialElement(i, j, estimate);
      }
    }
    if (!any) KeepInitialOutput(i, estimate);
  }
}

// The largest change of dead time that a clock may have made, in the model's
// time unit. In samples, a clock says nothing.
double MostOfClocks(const CorrectionResult& result) {
  return result.options.decision.clock_error /
         SecondsPerUnit(result.initial.time_unit())
             .value_or(std::numeric_limits<double>::infinity());
}

StepResponse Delayed(const ProcessModel& model, const SharedDelay& shared,
                     double sample_time, int samples) {
  ProcessModel late = model;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      TransferFunction& element = late.element(i, j);
      if (!shared.contains(i, j) || element.IsZero()) continue;
      element.set_delay(std::max(0.0, element.delay() + shared.change));
    }
  }
  return late.ComputeStepResponse(sample_time, samples);
}

// Whether a proposal for dead times, gain and time constant of (i, j).
bool IsParametric(const Estimate& estimate, int i, int j) {
  return ProposesElement(estimate, i, j) && !ProposesByArx(estimate, i) &&
         !ProposesShape(estimate, i);
}

void WithdrawSharedDelays(const StepResponse& proposed,
                          CorrectionResult& result) {
  Estimate& estimate = result.estimate;
  const double most = MostOfClocks(result);
  if (!ProposesAny(estimate) || !(most > 0.0)) return;
  const double sample_time = result.data.sample_time();
  for (const SharedDelay& shared :
       FindSharedDelays(estimate.fit.output_error.full, sample_time)) {
    if (std::abs(shared.change) > most) continue;
    result.shared_delays.push_back(shared);
    const StepResponse delayed =
        Delayed(result.initial, shared, sample_time, proposed.samples());
    for (int i = 0; i < proposed.num_outputs; ++i) {
      for (int j = 0; j < proposed.num_inputs; ++j) {
        if (!shared.contains(i, j) || !IsParametric(estimate, i, j)) continue;
        const double rest =
            (proposed.element(i, j) - delayed.element(i, j)).norm();
        if (rest > result.options.decision.least_change *
                       delayed.element(i, j).norm()) {
          continue;
        }
        KeepInitialElement(i, j, estimate);
        result.taken_for_clocks[i] =
            absl::StrCat(shared.Describe(result.initial),
                         ", and nothing else has. What a clock is known to be "
                         "wrong by, or that it is right, would settle it.");
      }
    }
  }
}

}  // namespace

absl::Status WithdrawProposals(int samples, CorrectionResult& result) {
  result.taken_for_clocks.resize(result.initial.num_outputs());
  MLE_ASSIGN_OR_RETURN(const CorrectedModel proposed,
                       MakeCorrectedModel(result.estimate, true,
                                          result.data.sample_time(), samples,
                                          /*make_arx=*/false));
  WithdrawSmallChanges(proposed.response, result);
  WithdrawSharedDelays(proposed.response, result);
  return absl::OkStatus();
}

}  // namespace mle
