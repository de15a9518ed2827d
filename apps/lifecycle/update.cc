#include "apps/lifecycle/update.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/correct/validation.h"
#include "mle/base/status.h"
#include "mle/model/process_model.h"

namespace mle::lifecycle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr double kAcceptedGap = 1e-6;

constexpr std::array<std::pair<Outcome, std::string_view>, 5> kNames = {{
    {Outcome::kNone, "none"},
    {Outcome::kNoChange, "no change"},
    {Outcome::kUpdated, "updated"},
    {Outcome::kRefused, "refused"},
    {Outcome::kReverted, "reverted"},
}};

UpdateResult Refuse(std::string reason, double gain) {
  UpdateResult result;
  result.outcome = Outcome::kRefused;
  result.reason = std::move(reason);
  result.held_out_gain = gain;
  return result;
}

// The worse of the two ways of holding out; NaN if there is neither.
double WorstGain(const correct::Validation& validation) {
  double worst = kNaN;
  for (const auto* way : {&validation.windows, &validation.blocks}) {
    if (!way->has_value() || !(*way)->available()) continue;
    worst = std::isnan(worst) ? (*way)->gain : std::min(worst, (*way)->gain);
  }
  return worst;
}

// The corrected model of an accepted estimate.
absl::StatusOr<ModelInUse> MakeModel(const correct::Estimate& estimate,
                                     double sample_time,
                                     const UpdateOptions& options) {
  const StructuredFit& structured = estimate.fit.structured.corrected;
  const ProcessModel& process = structured.model;
  for (const FitCertificate& certificate : structured.certificates) {
    if (certificate.termination == FitTermination::kFailed) {
      return absl::FailedPreconditionError(
          absl::StrCat("a fit failed: ", certificate.message));
    }
  }
  const bool arx =
      estimate.setting.options.estimator == correct::Estimator::kArx;
  if (!arx && !estimate.fit.arx.has_value()) {
    return UseProcess(process, options.control_period);
  }
  // Long enough for the controller, which holds the last value.
  const int settled =
      static_cast<int>(std::ceil(3.0 * SettlingTime(process) / sample_time));
  MLE_ASSIGN_OR_RETURN(const correct::CorrectedModel corrected,
                       correct::MakeCorrectedModel(
                           estimate, /*accepted=*/true, sample_time,
                           std::max(settled + 1, options.response_samples)));
  if (!(corrected.max_relative_gap <= kAcceptedGap)) {
    return absl::FailedPreconditionError(
        absl::StrCat("a lasso fit has a relative duality gap of ",
                     corrected.max_relative_gap, ", more than ", kAcceptedGap));
  }
  ModelInUse model;
  model.process = arx ? estimate.setting.initial : process;
  model.own_response = true;
  model.response = corrected.response;
  model.predictor = estimate.fit.corrected;
  std::vector<InputRole> roles;
  for (const InputChannel& input : process.inputs())
    roles.push_back(input.role);
  MLE_ASSIGN_OR_RETURN(model.prediction,
                       control::PredictFromStepResponse(
                           corrected.response, roles, options.control_period));
  return model;
}

}  // namespace

std::string_view NameOf(Outcome outcome) {
  for (const auto& [value, name] : kNames) {
    if (value == outcome) return name;
  }
  return "";
}

absl::StatusOr<Outcome> ParseOutcome(std::string_view name) {
  for (const auto& [value, known] : kNames) {
    if (known == name) return value;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no outcome '", std::string(name),
      "'; known are none, no change, updated, refused and reverted"));
}

absl::StatusOr<UpdateResult> UpdateModel(const ModelInUse& in_use,
                                         const std::vector<Record>& windows,
                                         const UpdateOptions& options) {
  const double sample_time = windows.front().sample_time;
  absl::StatusOr<correct::Estimate> estimate =
      correct::EstimateModel(in_use.process, windows, options.estimation);
  if (!estimate.ok()) {
    return Refuse(absl::StrCat("not estimated: ", estimate.status().message()),
                  kNaN);
  }
  UpdateResult result;
  result.held_out_gain = kNaN;
  if (!estimate->fit.change_proposed) {
    result.outcome = Outcome::kNoChange;
    return result;
  }
  // The rival is what the controller runs on.
  if (in_use.own_response) estimate->fit.initial = in_use.predictor;
  correct::ValidationOptions trial;
  trial.max_folds = options.validation_folds;
  trial.order = options.estimation.conversion.order > 0
                    ? options.estimation.conversion.order
                    : correct::ChooseOrder(in_use.process, sample_time);
  MLE_ASSIGN_OR_RETURN(const correct::Validation validation,
                       correct::Validate(*estimate, windows, trial));
  const double gain = WorstGain(validation);
  if (!(gain > options.least_gain)) {
    return Refuse(
        std::isnan(gain)
            ? "nothing could be held out"
            : "predicts what was held out worse than the model in use",
        gain);
  }
  absl::StatusOr<ModelInUse> model = MakeModel(*estimate, sample_time, options);
  if (!model.ok()) {
    return Refuse(absl::StrCat("not usable: ", model.status().message()), gain);
  }
  result.outcome = Outcome::kUpdated;
  result.held_out_gain = gain;
  result.model = *std::move(model);
  return result;
}

}  // namespace mle::lifecycle
