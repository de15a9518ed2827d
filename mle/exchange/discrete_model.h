// A matrix of discrete transfer functions with dead time, as identification
// tools write them,
//
//   g(z) = z^{−d} (b_0 z^q + … + b_q) / (a_0 z^r + … + a_r),
//
// or with b and a in rising powers of z⁻¹. Inputs are held from sample to
// sample and outputs measured just before the inputs change, so that no output
// follows an input within a sample: d + r − q ≥ 1 where b_0 is not 0. Elements
// are stable or integrate once (a pole at z = 1).
//
// The JSON form is in docs/formats.md (discrete transfer functions):
//
//   MLE_ASSIGN_OR_RETURN(const DiscreteModel model,
//                        ParseDiscreteModel(text, "column.json"));
//   MLE_ASSIGN_OR_RETURN(const StepResponseModel steps,
//                        StepResponsesOf(model));

#ifndef MLE_EXCHANGE_DISCRETE_MODEL_H_
#define MLE_EXCHANGE_DISCRETE_MODEL_H_

#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/exchange/step_response_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle {

enum class DiscreteVariable { kZ, kInverseZ };

struct DiscreteElement {
  int output = 0;
  int input = 0;
  // As in the file: falling powers of z, or rising ones of z⁻¹.
  std::vector<double> numerator;
  std::vector<double> denominator;
  int delay = 0;  // d ≥ 0, in samples
};

struct DiscreteModel {
  // Name, unit of time, inputs and outputs; all elements zero.
  ProcessModel channels;
  double sample_time = 0.0;  // Δt > 0
  DiscreteVariable variable = DiscreteVariable::kZ;
  // In the order of the file, each pair once; others are zero.
  std::vector<DiscreteElement> elements;

  // Names the element and what is wrong: coefficients that are not finite, a
  // denominator that begins with 0, feedthrough, poles that are unstable.
  absl::Status Validate() const;
};

// Step response of a valid model, by its difference equations: h(kΔt), k = 0 …
// samples − 1.
StepResponse ComputeStepResponse(const DiscreteModel& model, int samples);

// Step responses of a valid model: every pair until its slowest mode has
// decayed to 1e-4, pairs with a pole at z = 1 as ramps
// (state_space_responses.h).
absl::StatusOr<StepResponseModel> StepResponsesOf(const DiscreteModel& model);

// `element` under held inputs, exact to rounding: poles e^{pΔt}; `element` has
// an output, an input and a dead time of up to 10⁷ samples.
absl::StatusOr<DiscreteElement> Discretized(const TransferFunction& element,
                                            double sample_time,
                                            DiscreteVariable variable);

// `model` with Discretized() elements of `after` where they differ from those
// of `before`, in their places; others keep every bit. Pairs that are not in
// `model` are appended.
absl::StatusOr<DiscreteModel> WithChange(const DiscreteModel& model,
                                         const ProcessModel& before,
                                         const ProcessModel& after);

// Errors name `source` and the key; FormatDiscreteModel() reads back bit by
// bit.
absl::StatusOr<DiscreteModel> ParseDiscreteModel(std::string_view json,
                                                 std::string_view source);
std::string FormatDiscreteModel(const DiscreteModel& model);

}  // namespace mle

#endif  // MLE_EXCHANGE_DISCRETE_MODEL_H_
