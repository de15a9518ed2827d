#include "mle/maintain/correct.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/maintain/certificates.h"

namespace mle {
namespace {

constexpr double kFewestResponseSamples = 5.0;
constexpr double kMostResponseSamples = 1e6;
// Of Δt: the smallest time constant of fopdt_model, that of a jump.
constexpr double kTimeFloor = 1e-3;

absl::Status NotPositive(const char* field, double value) {
  return absl::InvalidArgumentError(absl::StrCat(
      field, " = ", value, ": it must be finite and greater than 0"));
}

absl::StatusOr<int> ResponseSamples(const ProcessModel& model,
                                    double sample_time,
                                    const CorrectOptions& options) {
  const double horizon = options.response_horizon > 0.0
                             ? options.response_horizon
                             : SettlingTime(model);
  const double samples = std::round(horizon / sample_time) + 1.0;
  if (!(samples >= kFewestResponseSamples) ||
      !(samples <= kMostResponseSamples)) {
    return OptionError(
        "response_horizon",
        absl::StrCat("response_horizon = ", options.response_horizon, " gives ",
                     samples, " samples at a sample time of ", sample_time,
                     "; from 5 to 1,000,000 are possible"));
  }
  return static_cast<int>(samples);
}

int OrderOf(const CorrectOptions& options, const ProcessModel& model,
            double sample_time) {
  return options.estimation.conversion.order > 0
             ? options.estimation.conversion.order
             : ChooseOrder(model, sample_time);
}

// What was measured and by which models it is predicted.
absl::Status Validate(const std::vector<Record>& windows, int order,
                      CorrectionResult& result) {
  const CorrectOptions& options = result.options;
  // The rival is what the controller runs on.
  if (options.in_use) result.estimate.fit.initial = options.in_use;
  MLE_ASSIGN_OR_RETURN(
      result.validation,
      ValidateByHoldOut(result.estimate, windows, order, options.hold_out,
                        options.threads, options.progress));
  Verdict verdict =
      Decide({.change_proposed = result.estimate.fit.change_proposed,
              .p_value = result.estimate.fit.PValue(),
              .held_out_gain = result.validation.WorstGain()},
             options.decision);
  result.decision = verdict.decision;
  result.reasons = std::move(verdict.reasons);
  // What forbids a correction comes before what speaks for one.
  if (!result.data.obstacles.empty()) {
    result.decision = Decision::kRefused;
    result.reasons = result.data.obstacles;
  }
  return absl::OkStatus();
}

absl::Status MakeModels(CorrectionResult& result) {
  const double sample_time = result.data.sample_time();
  MLE_ASSIGN_OR_RETURN(
      const int samples,
      ResponseSamples(result.initial, sample_time, result.options));
  result.initial_response =
      result.initial.ComputeStepResponse(sample_time, samples);
  MLE_ASSIGN_OR_RETURN(
      result.corrected,
      MakeCorrectedModel(result.estimate, result.accepted(), sample_time,
                         samples, result.options.make_arx));
  MLE_RETURN_IF_ERROR(CheckResponse(result.corrected.response));
  result.change =
      CompareResponses(result.initial_response, result.corrected.response);
  MLE_ASSIGN_OR_RETURN(
      result.fopdt,
      DescribeAsFopdt(result.estimate, result.accepted(), result.corrected));
  result.fopdt_model =
      FopdtModel(result.initial, result.fopdt, kTimeFloor * sample_time);
  return absl::OkStatus();
}

absl::Status Examine(const std::vector<Record>& windows, int order,
                     CorrectionResult& result) {
  CheckCertificates(result);
  if (!result.options.examine) return absl::OkStatus();
  const Stage stage(result.options.progress, "examining the residuals");
  MLE_RETURN_IF_ERROR(stage.status());
  const EstimateFit& fit = result.estimate.fit;
  result.max_lag = order;
  result.initial_residuals = ExamineResiduals(fit.initial, windows, order);
  result.corrected_residuals =
      result.accepted() ? ExamineResiduals(fit.corrected, windows, order)
                        : result.initial_residuals;
  return absl::OkStatus();
}

absl::Status CheckModel(const ProcessModel& model) {
  MLE_RETURN_IF_ERROR(model.Validate());
  if (SettlingTime(model) > 0.0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "the model '", model.name(),
      "' has no element with a time constant or a dead time: there is nothing "
      "to correct"));
}

}  // namespace

absl::Status CorrectOptions::Validate() const {
  MLE_RETURN_IF_ERROR(records.Validate());
  MLE_RETURN_IF_ERROR(estimation.Validate());
  MLE_RETURN_IF_ERROR(hold_out.Validate());
  MLE_RETURN_IF_ERROR(decision.Validate());
  if (!(response_horizon >= 0.0) || !std::isfinite(response_horizon)) {
    return OptionError(
        "response_horizon",
        absl::StrCat("response_horizon = ", response_horizon,
                     ": it must be a time > 0, or 0 for the default"));
  }
  if (!(accepted_gap > 0.0) || !std::isfinite(accepted_gap)) {
    return NotPositive("accepted_gap", accepted_gap);
  }
  if (!(accepted_gradient > 0.0) || !std::isfinite(accepted_gradient)) {
    return NotPositive("accepted_gradient", accepted_gradient);
  }
  if (threads < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("threads = ", threads, ": it must not be negative"));
  }
  return absl::OkStatus();
}

ResponseDistance CompareResponses(const StepResponse& from,
                                  const StepResponse& to) {
  ResponseDistance distance;
  distance.total = SquaredDistance(from, to);
  const double size = from.values.squaredNorm();
  distance.relative = size > 0.0 ? std::sqrt(distance.total / size) : 0.0;
  distance.elements = Eigen::MatrixXd::Zero(from.num_outputs, from.num_inputs);
  for (int i = 0; i < from.num_outputs; ++i) {
    for (int j = 0; j < from.num_inputs; ++j) {
      const double norm = from.element(i, j).norm();
      if (!(norm > 0.0)) continue;
      distance.elements(i, j) =
          (from.element(i, j) - to.element(i, j)).norm() / norm;
    }
  }
  return distance;
}

absl::StatusOr<CorrectionResult> CorrectFromData(
    const ProcessModel& model, RecordData data, const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckModel(model));
  CorrectionResult result;
  result.initial = model;
  result.options = options;
  result.options.estimation.structured.threads = options.threads;
  result.data = std::move(data);
  if (result.data.windows.empty()) {
    return absl::InvalidArgumentError("there are no windows");
  }
  const EstimationOptions& estimation = result.options.estimation;
  const double sample_time = result.data.sample_time();
  MLE_RETURN_IF_ERROR(ResponseSamples(model, sample_time, options).status());
  if (ShouldLookForOutliers(options.records, estimation.structured,
                            result.data)) {
    const Stage stage(options.progress, "looking for outliers");
    MLE_RETURN_IF_ERROR(stage.status());
    MLE_RETURN_IF_ERROR(
        MarkOutliersByModel(model, estimation.structured, result.data));
  }
  result.notes = result.data.notes;
  result.warnings = result.data.warnings;
  const std::vector<Record> windows = result.data.Records();
  MLE_ASSIGN_OR_RETURN(
      result.estimate,
      EstimateModel(model, windows, estimation, options.progress));
  if (options.examine) {
    MLE_ASSIGN_OR_RETURN(
        result.information,
        AssessInformation(model, windows, result.estimate.setting.noise,
                          {.structured = estimation.structured}));
  }
  const int order = OrderOf(result.options, model, sample_time);
  MLE_RETURN_IF_ERROR(Validate(windows, order, result));
  const Stage making(options.progress, "making the corrected model");
  MLE_RETURN_IF_ERROR(making.status());
  MLE_RETURN_IF_ERROR(MakeModels(result));
  MLE_RETURN_IF_ERROR(Examine(windows, order, result));
  return result;
}

absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const ProcessModel& model, std::vector<Record> records,
    const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckModel(model));
  MLE_ASSIGN_OR_RETURN(RecordData data, PrepareRecords(std::move(records),
                                                       model, options.records));
  return CorrectFromData(model, std::move(data), options);
}

absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const std::string& model_path, const std::vector<std::string>& record_paths,
    const HistorianOptions& import, const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(const ProcessModel model, ReadProcessModel(model_path));
  MLE_RETURN_IF_ERROR(CheckModel(model));
  MLE_ASSIGN_OR_RETURN(RecordData data, LoadRecords(record_paths, model, import,
                                                    options.records));
  return CorrectFromData(model, std::move(data), options);
}

}  // namespace mle
