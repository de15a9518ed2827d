#include "mle/maintain/corrected_model.h"

#include <algorithm>
#include <utility>

#include "mle/base/status.h"
#include "mle/maintain/exact_arx.h"
#include "mle/nonlinear/rational_fit.h"

namespace mle {
namespace {

// By which a dead time of an ARX model may grow beyond its double.
constexpr double kDelaySamples = 10.0;

// R + ΔR for the outputs that it is for; the others have the process model's
// own responses, and rows that run as these.
CorrectedModel WithArx(const Estimate& estimate, double sample_time,
                       int response_samples) {
  const EstimateSetting& setting = estimate.setting;
  const EstimateFit& fit = estimate.fit;
  CorrectedModel corrected;
  corrected.max_relative_gap =
      std::max(setting.conversion->max_relative_gap, fit.arx_gap);
  corrected.arx = Unscaled(fit.arx_model, setting.scales);
  const std::vector<bool>& own = setting.arx_outputs;
  const bool all = std::find(own.begin(), own.end(), false) == own.end();
  if (all) {
    corrected.response = corrected.arx.ComputeStepResponse(response_samples);
    return corrected;
  }
  const ProcessModel& process = setting.initial;
  ConversionSettings conversion = setting.options.conversion;
  conversion.order = corrected.arx.order;
  const ExactArx exact = ArxOfModel(process, sample_time, conversion);
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (own[i]) continue;
    corrected.arx.R.row(row) = exact.model.R.row(row);
    corrected.arx_error = std::max(corrected.arx_error, exact.errors(row));
  }
  corrected.response = corrected.arx.ComputeStepResponse(response_samples);
  const StepResponse responses =
      process.ComputeStepResponse(sample_time, response_samples);
  for (int i = 0; i < responses.num_outputs; ++i) {
    for (int j = 0; !own[i] && j < responses.num_inputs; ++j) {
      corrected.response.element(i, j) = responses.element(i, j);
    }
  }
  return corrected;
}

}  // namespace

absl::StatusOr<CorrectedModel> MakeCorrectedModel(const Estimate& estimate,
                                                  bool accepted,
                                                  double sample_time,
                                                  int response_samples,
                                                  bool make_arx) {
  const EstimateSetting& setting = estimate.setting;
  if (accepted && estimate.fit.arx != nullptr) {
    return WithArx(estimate, sample_time, response_samples);
  }
  CorrectedModel corrected;
  // The estimator arx proposes ΔR alone.
  const bool changed = accepted && setting.options.estimator != Estimator::kArx;
  corrected.process =
      changed ? estimate.fit.output_error.corrected.model : setting.initial;
  corrected.response =
      corrected.process->ComputeStepResponse(sample_time, response_samples);
  corrected.errors =
      changed ? estimate.fit.output_error.corrected.StepResponseErrors(
                    sample_time, response_samples)
              : StepResponse(sample_time, setting.initial.num_outputs(),
                             setting.initial.num_inputs(), response_samples);
  if (!make_arx) return corrected;
  ExactArx exact =
      ArxOfModel(*corrected.process, sample_time, setting.options.conversion);
  corrected.arx = std::move(exact.model);
  corrected.arx_error = exact.errors.maxCoeff();
  return corrected;
}

absl::StatusOr<ProcessModel> TransferFunctionsOf(
    const ProcessModel& initial, const CorrectedModel& corrected) {
  if (corrected.process.has_value()) return *corrected.process;
  ProcessModel model(initial.name(), initial.time_unit(), initial.inputs(),
                     initial.outputs());
  const StepResponse& response = corrected.response;
  const StepResponse before =
      initial.ComputeStepResponse(response.sample_time, response.samples());
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (response.element(i, j) == before.element(i, j)) {
        model.element(i, j) = initial.element(i, j);
        continue;
      }
      RationalOptions options;
      options.max_delay = 2.0 * initial.element(i, j).delay() +
                          kDelaySamples * response.sample_time;
      MLE_ASSIGN_OR_RETURN(
          RationalFit fit,
          FitRational(response.element(i, j), response.sample_time, options));
      model.element(i, j) = std::move(fit.element);
    }
  }
  return model;
}

}  // namespace mle
