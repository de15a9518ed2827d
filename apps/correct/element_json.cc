// The part of result.json about one element.

#include <string>

#include "apps/correct/report.h"
#include "apps/correct/result_json.h"

namespace mle::correct {
namespace {

using Json = nlohmann::ordered_json;

const char* StateName(ElementState state) {
  switch (state) {
    case ElementState::kAbsent:
      return "absent";
    case ElementState::kNotInformed:
      return "not_informed";
    case ElementState::kHeld:
      return "held";
    case ElementState::kFitted:
      return "fitted";
  }
  return "";
}

const char* ShapeName(FopdtShape shape) {
  switch (shape) {
    case FopdtShape::kFits:
      return "fits";
    case FopdtShape::kNoResponse:
      return "no_response";
    case FopdtShape::kPoorFit:
      return "poor_fit";
  }
  return "";
}

Json EstimateJson(const ParameterEstimate& estimate) {
  return {{"value", estimate.value},
          {"standard_error", estimate.standard_error},
          {"lower", estimate.lower},
          {"upper", estimate.upper}};
}

// One parameter: as it was, from the fit with every element free, and as it is
// written.
Json ParameterJson(const ParameterEstimate& full,
                   const ParameterEstimate& corrected, bool accepted) {
  Json json = {{"initial", full.initial}, {"all_free", EstimateJson(full)}};
  if (accepted) json["corrected"] = EstimateJson(corrected);
  return json;
}

Json FopdtJson(const FopdtElement& element, bool errors_from_records) {
  Json json = {
      {"gain", element.gain},
      {"time_constant", element.time_constant},
      {"delay", element.delay},
      {"gain_standard_error", element.gain_error},
      {"time_constant_standard_error", element.time_constant_error},
      {"delay_standard_error", element.delay_error},
      {"standard_errors_from", errors_from_records ? "records" : "fit"},
      {"exact", element.exact},
      {"shape", ShapeName(element.shape)},
      {"relative_rms", element.relative_rms},
      {"largest_difference", element.largest_difference}};
  if (element.integrating) json["integrating"] = true;
  return json;
}

Json SopdtJson(const SopdtFit& fit) {
  return {{"gain", fit.gain},
          {"time_constant", fit.time_constant},
          {"damping", fit.damping},
          {"delay", fit.delay},
          {"largest_difference", fit.largest_difference}};
}

}  // namespace

Json ElementJson(const Result& result, int i, int j) {
  const ProcessModel& model = result.initial;
  const OutputErrorCorrection& output_error = result.estimate.fit.output_error;
  const ElementEstimate& full = output_error.full.element(i, j);
  const ElementEstimate& corrected = output_error.corrected.element(i, j);
  const bool structural = result.corrected.process.has_value();
  Json json = {{"output", model.outputs()[i].name},
               {"input", model.inputs()[j].name},
               {"state", StateName(full.state)},
               {"information",
                std::string(NameOf(result.information.pair(i, j).state))}};
  if (full.state == ElementState::kFitted) {
    json["expected_relative_gain_error"] = result.information.pair(i, j).gain;
    json["p_value"] = output_error.element_p_values(i, j);
    json["aged"] = static_cast<bool>(output_error.aged(i, j));
  }
  if (HasOtherShape(result, i, j)) json["reshaped"] = true;
  if (model.element(i, j).IsIntegrating()) json["integrating"] = true;
  if (full.state != ElementState::kAbsent) {
    const bool shown = structural && result.accepted();
    json["gain"] = ParameterJson(full.gain, corrected.gain, shown);
    json["time_constant"] =
        ParameterJson(full.time_scale, corrected.time_scale, shown);
    json["delay"] = ParameterJson(full.delay, corrected.delay, shown);
    if (shown) {
      json["gain_ratio"] = corrected.gain.value / corrected.gain.initial;
      json["delay_shift"] = corrected.delay.value - corrected.delay.initial;
    }
  }
  json["response_change"] = result.change.elements(i, j);
  json["fopdt"] =
      FopdtJson(result.fopdt[i * model.num_inputs() + j], structural);
  const auto& second = result.fopdt[i * model.num_inputs() + j].second_order;
  if (second.has_value()) json["sopdt"] = SopdtJson(*second);
  return json;
}

}  // namespace mle::correct
