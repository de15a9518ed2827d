#include "mle/maintain/withdrawal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/maintain/corrected_model.h"
#include "mle/maintain/shared_changes.h"
#include "mle/nonlinear/distributions.h"

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

// By which a tag may be late since it waits for a scan or an average.
constexpr double kLateSamples = 5.0;

// The largest change of dead time that a clock may have made, in the model's
// time unit. Where that is samples, seconds say nothing.
double MostOfClocks(const CorrectionResult& result) {
  const double seconds = result.options.decision.clock_error;
  if (!(seconds > 0.0)) return 0.0;
  return std::max(
      seconds / SecondsPerUnit(result.initial.time_unit())
                    .value_or(std::numeric_limits<double>::infinity()),
      kLateSamples * result.data.sample_time());
}

StepResponse DelayedResponse(const ProcessModel& model,
                             const SharedDelay& shared, double sample_time,
                             int samples) {
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

// Whether the estimate of (i, j) has no more than the shared change to it.
bool NothingElse(const OutputErrorFit& full, const SharedDelay& shared, int i,
                 int j) {
  constexpr double kSignificant = 0.01;
  const ElementEstimate& element = full.element(i, j);
  Eigen::Vector3d change;
  change << element.gain.value - element.gain.initial,
      element.time_scale.value - element.time_scale.initial,
      element.delay.value - element.delay.initial -
          std::max(shared.change, -element.delay.initial);
  const Eigen::Matrix3d covariance =
      full.covariances[i].block<3, 3>(3 * j, 3 * j);
  const Eigen::LDLT<Eigen::Matrix3d> factors(covariance);
  if (!covariance.allFinite() || !factors.isPositive()) return false;
  return ChiSquareTail(change.dot(factors.solve(change)), 3) > kSignificant;
}

// Whether a proposal for dead times, gain and time constant of (i, j).
bool IsParametric(const Estimate& estimate, int i, int j) {
  return ProposesElement(estimate, i, j) && !ProposesByArx(estimate, i) &&
         !ProposesShape(estimate, i);
}

// What else is proposed of (i, j) is right under either explanation.
void TakeOff(const SharedDelay& shared, int i, int j,
             CorrectionResult& result) {
  OutputErrorFit& fit = result.estimate.fit.output_error.corrected;
  TransferFunction& element = fit.model.element(i, j);
  ParameterEstimate& delay = fit.elements[i * fit.model.num_inputs() + j].delay;
  // No dead time has become shorter by more than it was.
  const double change = std::max(shared.change, -delay.initial);
  element.set_delay(std::max(0.0, element.delay() - change));
  for (double* value : {&delay.value, &delay.lower, &delay.upper}) {
    *value = std::max(0.0, *value - change);
  }
}

void WithdrawSharedDelays(const StepResponse& proposed,
                          CorrectionResult& result) {
  Estimate& estimate = result.estimate;
  const double most = MostOfClocks(result);
  if (!ProposesAny(estimate) || !(most > 0.0)) return;
  const double sample_time = result.data.sample_time();
  for (const SharedDelay& shared :
       FindSharedDelays(estimate.fit.output_error.full, sample_time)) {
    if (std::abs(shared.change) > most && !shared.impossible) continue;
    result.shared_delays.push_back(shared);
    bool with_others = false;
    const StepResponse delayed = DelayedResponse(
        result.initial, shared, sample_time, proposed.samples());
    for (int i = 0; i < proposed.num_outputs; ++i) {
      for (int j = 0; j < proposed.num_inputs; ++j) {
        if (!shared.contains(i, j) || !IsParametric(estimate, i, j)) continue;
        const double rest =
            (proposed.element(i, j) - delayed.element(i, j)).norm();
        if (rest > result.options.decision.least_change *
                       delayed.element(i, j).norm() &&
            !NothingElse(estimate.fit.output_error.full, shared, i, j)) {
          TakeOff(shared, i, j, result);
          with_others = true;
          continue;
        }
        KeepInitialElement(i, j, estimate);
        result.taken_for_clocks[i] =
            absl::StrCat(shared.Describe(result.initial),
                         ", and nothing else has. What a clock is known to be "
                         "wrong by, or that it is right, would settle it.");
      }
    }
    if (!with_others) continue;
    result.warnings.push_back(
        {MessageCode::kClock,
         shared.Channel(result.initial),
         absl::StrCat(shared.Describe(result.initial),
                      ". These dead times are left as they were."),
         {"clock_error"}});
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
  result.proposed = result.estimate.fit.output_error.corrected;
  WithdrawSharedDelays(proposed.response, result);
  return absl::OkStatus();
}

}  // namespace mle
