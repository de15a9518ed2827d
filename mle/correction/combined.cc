#include "mle/correction/combined.h"

#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle {

std::vector<bool> WrongOutputs(const ModelAdequacy& adequacy,
                               double false_alarm_probability) {
  const Eigen::VectorXd& p_values = adequacy.output_p_values;
  std::vector<bool> wrong(p_values.size());
  if (adequacy.adequate) return wrong;
  for (Eigen::Index i = 0; i < p_values.size(); ++i) {
    wrong[i] = p_values(i) < false_alarm_probability /
                                 static_cast<double>(p_values.size()) ||
               p_values(i) == p_values.minCoeff();
  }
  return wrong;
}

absl::Status CombinedOptions::Validate() const {
  if (!(false_alarm_probability > 0.0 && false_alarm_probability < 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("combined correction: false_alarm_probability is ",
                     false_alarm_probability, ", must be between 0 and 1"));
  }
  MLE_RETURN_IF_ERROR(structured.Validate());
  return correction.Validate();
}

StepResponse CombinedCorrection::ComputeStepResponse(double sample_time,
                                                     int samples) const {
  StepResponse response =
      structured.corrected.model.ComputeStepResponse(sample_time, samples);
  if (!correction.has_value()) return response;
  const ArxModel model = correction->Model();
  CHECK_LE(std::abs(model.sample_time - sample_time), 1e-9 * sample_time);
  const StepResponse arx = model.ComputeStepResponse(samples);
  for (int i = 0; i < model.num_outputs; ++i) {
    for (int j = 0; outputs_corrected[i] && j < model.num_inputs; ++j) {
      response.element(i, j) = arx.element(i, j);
    }
  }
  return response;
}

absl::StatusOr<CombinedCorrection> CompleteStructured(
    const ProcessModel& initial, StructuredCorrection structured,
    const std::vector<Record>& windows, const ArxConverter& convert,
    const CombinedOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (!convert) {
    return absl::InvalidArgumentError(
        "combined correction: no conversion is given");
  }
  CombinedCorrection combined;
  combined.structured = std::move(structured);
  AdequacyOptions adequacy = AdequacyOptionsFor(options.structured);
  adequacy.false_alarm_probability = options.false_alarm_probability;
  const ProcessModel& corrected = combined.structured.corrected.model;
  MLE_ASSIGN_OR_RETURN(
      combined.adequacy,
      TestAdequacy(corrected, windows, combined.structured.aged, adequacy));
  if (combined.adequacy.adequate) return combined;
  const std::vector<bool> wrong =
      WrongOutputs(combined.adequacy, options.false_alarm_probability);
  ProcessModel start = corrected;
  for (int i = 0; i < start.num_outputs(); ++i) {
    for (int j = 0; wrong[i] && j < start.num_inputs(); ++j) {
      start.element(i, j) = initial.element(i, j);
    }
  }
  MLE_ASSIGN_OR_RETURN(combined.conversion, convert(start));
  MLE_ASSIGN_OR_RETURN(
      combined.correction,
      CorrectModel(combined.conversion->model, windows, options.correction));
  combined.outputs_corrected = wrong;
  return combined;
}

}  // namespace mle
