#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/lifecycle/life.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/nonlinear/low_order_fit.h"

namespace mle::lifecycle {
namespace {

// Where windows disagree, the plant may have aged in between: the oldest are
// left out, down to so many.
constexpr std::size_t kFewestWindows = 2;

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

// One step ahead, of the outputs that a change is proposed for.
double LeastGain(const CorrectionResult& result) {
  double least = kNaN;
  for (std::size_t i = 0; i < result.validation.outputs.size(); ++i) {
    const double gain = result.validation.outputs[i].one_step.gain;
    if (std::isfinite(gain) && !(gain >= least)) least = gain;
  }
  return least;
}

// The model that was handed over, for the controller.
absl::StatusOr<ModelInUse> MakeModel(const CorrectionResult& result,
                                     const UpdateOptions& options) {
  if (!result.usable()) {
    return absl::FailedPreconditionError(result.failures.front().text);
  }
  if (result.corrected.process.has_value()) {
    return UseProcess(*result.corrected.process, options.control_period);
  }
  const bool arx = result.options.estimation.estimator == Estimator::kArx;
  ModelInUse model;
  model.process =
      arx ? result.initial : result.estimate.fit.output_error.corrected.model;
  model.own_response = true;
  model.response = result.corrected.response;
  model.predictor = result.estimate.fit.corrected;
  MLE_ASSIGN_OR_RETURN(
      model.prediction,
      control::PredictFromStepResponse(
          model.response, InputRoles(result.initial), options.control_period));
  return model;
}

// An update from these windows.
struct Attempt {
  UpdateResult update;
  bool windows_disagree = false;
};

Attempt TryWindows(const ModelInUse& in_use, const std::vector<Record>& windows,
                   const UpdateOptions& options) {
  CorrectOptions correct = options.correct;
  // Long enough for the controller, which holds the last value.
  const double sample_time = windows.front().sample_time;
  const double settled = 3.0 * SettlingTime(in_use.process) / sample_time;
  correct.response_horizon =
      sample_time *
      std::max(std::ceil(settled), options.response_samples - 1.0);
  // The rival is what the controller runs on.
  if (in_use.own_response) correct.in_use = in_use.predictor;
  const absl::StatusOr<CorrectionResult> result =
      CorrectFromData(in_use.process, UseAsWindows(windows), correct);
  if (!result.ok()) {
    return {Refuse(absl::StrCat("not estimated: ", result.status().message()),
                   kNaN)};
  }
  UpdateResult update;
  update.held_out_gain = LeastGain(*result);
  switch (result->decision) {
    case Decision::kNoChange:
      update.outcome = Outcome::kNoChange;
      return {std::move(update)};
    case Decision::kCannotTell:
      return {Refuse(result->reasons.back().text, update.held_out_gain),
              std::any_of(result->reasons.begin(), result->reasons.end(),
                          [](const Message& reason) {
                            return reason.code == MessageCode::kWindowsDisagree;
                          })};
    case Decision::kCorrected:
      break;
  }
  absl::StatusOr<ModelInUse> model = MakeModel(*result, options);
  if (!model.ok()) {
    return {Refuse(absl::StrCat("not usable: ", model.status().message()),
                   update.held_out_gain)};
  }
  update.outcome = Outcome::kUpdated;
  update.model = *std::move(model);
  return {std::move(update)};
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
  return InvalidArgument(
      "there is no outcome '", std::string(name),
      "'; choose from none, no change, updated, refused and reverted");
}

CorrectOptions UpdateOptions::SimulatedRecords() {
  CorrectOptions options;
  options.records.mark = {.frozen = false, .outliers = false};
  options.hold_out.folds = 4;
  // A step test moves its only input, or the last one, up and back.
  options.hold_out.fewest_changes = 2;
  options.make_arx = false;
  options.examine = false;
  options.threads = 1;
  return options;
}

UpdateResult UpdateModel(const ModelInUse& in_use,
                         const std::vector<Record>& windows,
                         const UpdateOptions& options) {
  std::vector<Record> used = windows;
  while (true) {
    Attempt attempt = TryWindows(in_use, used, options);
    if (!attempt.windows_disagree || used.size() <= kFewestWindows) {
      return std::move(attempt.update);
    }
    used.erase(used.begin());
  }
}

namespace {

// The larger of both, NaN if either is.
double Larger(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? kNaN : std::max(a, b);
}

absl::StatusOr<double> DelayOf(const StepResponse& response, int i, int j) {
  const Eigen::VectorXd values = response.element(i, j);
  MLE_ASSIGN_OR_RETURN(const FopdtFit fit,
                       FitFopdt(values, response.sample_time, {}));
  return fit.shape == FopdtShape::kFits ? fit.delay : kNaN;
}

}  // namespace

absl::StatusOr<ModelInUse> UseProcess(const ProcessModel& process,
                                      double control_period) {
  ModelInUse model;
  model.process = process;
  MLE_ASSIGN_OR_RETURN(model.prediction,
                       control::PredictFromProcess(process, control_period));
  return model;
}

absl::StatusOr<ModelError> CompareWithPlant(const ModelInUse& model,
                                            const ProcessModel& plant,
                                            double sample_time, int samples) {
  const StepResponse truth = plant.ComputeStepResponse(sample_time, samples);
  StepResponse response = model.response;
  if (model.own_response) {
    response.values = model.response.values.topRows(samples).eval();
  } else {
    response = model.process.ComputeStepResponse(sample_time, samples);
  }
  ModelError error;
  error.distance = SquaredDistance(truth, response);
  for (const auto& [i, j] : Pairs(plant)) {
    const TransferFunction& element = plant.element(i, j);
    if (element.IsZero()) continue;
    const double gain = model.own_response
                            ? response.element(i, j)(samples - 1)
                            : model.process.element(i, j).StaticGain();
    const double true_gain = model.own_response
                                 ? truth.element(i, j)(samples - 1)
                                 : element.StaticGain();
    error.gain =
        std::max(error.gain, std::abs(gain - true_gain) / std::abs(true_gain));
    double delay = model.process.element(i, j).delay();
    if (model.own_response) {
      MLE_ASSIGN_OR_RETURN(delay, DelayOf(response, i, j));
    }
    error.delay = Larger(error.delay, std::abs(delay - element.delay()));
  }
  return error;
}

}  // namespace mle::lifecycle
