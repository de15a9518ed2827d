#include "mle/nonlinear/model_adequacy.h"

#include "absl/strings/str_cat.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

// The settling time is the longest of dead time + this many time scales.
constexpr double kSettlingTimeScales = 4.0;
// No lag is longer than this share of the shortest record.
constexpr double kMaxAdequacyLagShare = 0.25;

}  // namespace

AdequacyOptions AdequacyOptionsFor(const OutputErrorOptions& structure) {
  AdequacyOptions options;
  options.false_alarm_probability = structure.false_alarm_probability;
  options.estimate_drift = structure.estimate_drift;
  options.structure = structure;
  options.threads = structure.threads;
  return options;
}

absl::Status AdequacyOptions::Validate() const {
  if (!(false_alarm_probability > 0.0 && false_alarm_probability < 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("model adequacy: false_alarm_probability is ",
                     false_alarm_probability, ", must be between 0 and 1"));
  }
  if (threads < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "model adequacy: threads is ", threads, ", must be not negative"));
  }
  return structure.Validate();
}

absl::StatusOr<ModelAdequacy> TestAdequacy(const ProcessModel& model,
                                           const std::vector<Record>& records,
                                           const AdequacyOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputSetup> setups,
                       SetUpOutputs(model, records, options.structure));
  const std::vector<int> first_lags = LagRanges(
      LongestLag(setups, records, kSettlingTimeScales, kMaxAdequacyLagShare));
  const std::vector<bool> none(model.num_inputs(), false);
  std::vector<Contrast> evidence(setups.size());
  ParallelFor(static_cast<int>(setups.size()), options.threads, [&](int i) {
    const OutputSetup& setup = setups[i];
    if (setup.problem->num_segments() == 0) return;
    evidence[i] = ContrastWithColumns(
        ShapeLikelihood(*setup.problem, setup.start, none, NoiseShape(),
                        /*restricted=*/true),
        setup.problem->LagSums(first_lags), options.estimate_drift);
  });
  ModelAdequacy adequacy;
  for (const Contrast& contrast : evidence) {
    adequacy.statistic += contrast.statistic;
    adequacy.degrees_of_freedom += contrast.degrees;
  }
  if (adequacy.degrees_of_freedom > 0) {
    adequacy.p_value =
        ChiSquareTail(adequacy.statistic, adequacy.degrees_of_freedom);
  }
  adequacy.adequate = adequacy.p_value >= options.false_alarm_probability;
  return adequacy;
}

}  // namespace mle
