#include "mle/maintain/corrected_model.h"

#include <algorithm>
#include <utility>

#include "mle/base/status.h"

namespace mle {

absl::StatusOr<CorrectedModel> MakeCorrectedModel(const Estimate& estimate,
                                                  bool accepted,
                                                  double sample_time,
                                                  int response_samples,
                                                  bool make_arx) {
  const EstimateSetting& setting = estimate.setting;
  const EstimateFit& fit = estimate.fit;
  CorrectedModel corrected;
  // Without a conversion nothing was estimated (unfitted.h).
  const bool pure_arx = setting.options.estimator == Estimator::kArx &&
                        setting.conversion.has_value();
  if (pure_arx || (accepted && fit.arx.has_value())) {
    corrected.max_relative_gap = setting.conversion->max_relative_gap;
    ArxModel scaled = setting.conversion->model;
    if (accepted && fit.arx.has_value()) {
      for (std::size_t i = 0; i < setting.arx_outputs.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        if (setting.arx_outputs[i])
          scaled.R.row(row) = fit.arx_model.R.row(row);
      }
      corrected.max_relative_gap =
          std::max(corrected.max_relative_gap, fit.arx_gap);
    }
    corrected.arx = Unscaled(scaled, setting.scales);
    corrected.response = corrected.arx.ComputeStepResponse(response_samples);
    if (pure_arx) return corrected;
    // The outputs that are not ΔR's have the process model's own responses.
    const StepResponse process =
        fit.structured.corrected.model.ComputeStepResponse(sample_time,
                                                           response_samples);
    for (int i = 0; i < process.num_outputs; ++i) {
      for (int j = 0; !setting.arx_outputs[i] && j < process.num_inputs; ++j) {
        corrected.response.element(i, j) = process.element(i, j);
      }
    }
    return corrected;
  }
  const StructuredFit& structured = fit.structured.corrected;
  corrected.process = accepted ? structured.model : setting.initial;
  corrected.response =
      corrected.process->ComputeStepResponse(sample_time, response_samples);
  corrected.errors =
      accepted ? structured.StepResponseErrors(sample_time, response_samples)
               : StepResponse(sample_time, setting.initial.num_outputs(),
                              setting.initial.num_inputs(), response_samples);
  if (!make_arx) return corrected;
  MLE_ASSIGN_OR_RETURN(
      const ConversionSummary conversion,
      ConvertModel(setting, *corrected.process, setting.scales, sample_time));
  corrected.max_relative_gap = conversion.max_relative_gap;
  corrected.arx = Unscaled(conversion.model, setting.scales);
  return corrected;
}

}  // namespace mle
