#include "mle/maintain/unfitted.h"

#include <limits>

#include "absl/status/statusor.h"
#include "mle/maintain/channel_scales.h"
#include "mle/model/element_response.h"

namespace mle {
namespace {

ParameterEstimate At(double value) {
  return {.initial = value, .value = value, .lower = value, .upper = value};
}

ElementEstimate Held(const TransferFunction& element) {
  ElementEstimate held;
  if (element.IsZero()) return held;
  held.state = ElementState::kHeld;
  held.gain = At(element.StaticGain());
  held.time_scale = At(element.SlowestTimeConstant());
  held.delay = At(element.delay());
  // A gain of zero has another meaning there.
  if (const absl::StatusOr<ElementResponse> response =
          ElementResponse::Create(element);
      response.ok()) {
    held.gain = At(response->initial_values().gain);
  }
  return held;
}

}  // namespace

OutputErrorCorrection UnfittedStructure(const ProcessModel& initial) {
  const int p = initial.num_outputs();
  const int m = initial.num_inputs();
  OutputErrorCorrection none;
  none.full.model = initial;
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      none.full.elements.push_back(Held(initial.element(i, j)));
    }
  }
  none.full.covariances.assign(p, Eigen::MatrixXd::Zero(3 * m, 3 * m));
  none.full.noise.assign(p, {.offset = false});
  none.full.certificates.resize(p);
  none.full.offset_weight = 0.0;
  none.full.down_weighted_samples.assign(p, 0);
  none.full.deviances.assign(p, 0.0);
  none.corrected = none.full;
  none.element_p_values.setOnes(p, m);
  none.aged.setConstant(p, m, false);
  return none;
}

Estimate UnfittedEstimate(const ProcessModel& initial,
                          const std::vector<Record>& windows,
                          const EstimationOptions& options) {
  Estimate estimate;
  estimate.fit.output_error = UnfittedStructure(initial);
  EstimateSetting& setting = estimate.setting;
  setting.initial = initial;
  setting.options = options;
  setting.noise = estimate.fit.output_error.full.noise;
  setting.filler = initial;
  setting.scales = ChooseScales(initial, setting.noise, windows);
  setting.arx_outputs.assign(initial.num_outputs(), false);
  if (!MakePredictors(windows, estimate).ok()) {
    const Predictor nothing = [](const Record& record, int) {
      return Eigen::MatrixXd(
          Eigen::MatrixXd::Constant(record.num_outputs(), record.samples(),
                                    std::numeric_limits<double>::quiet_NaN()));
    };
    estimate.fit.initial = nothing;
    estimate.fit.corrected = nothing;
  }
  return estimate;
}

PairInformation NoInformation(const ProcessModel& initial) {
  PairInformation information;
  information.num_inputs = initial.num_inputs();
  for (int i = 0; i < initial.num_outputs(); ++i) {
    for (int j = 0; j < initial.num_inputs(); ++j) {
      information.pairs.push_back({.state = initial.element(i, j).IsZero()
                                                ? PairState::kAbsent
                                                : PairState::kNotInformed});
    }
  }
  information.inputs.resize(initial.num_inputs());
  information.input_correlation =
      Eigen::MatrixXd::Zero(initial.num_inputs(), initial.num_inputs());
  return information;
}

}  // namespace mle
