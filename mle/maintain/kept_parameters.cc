#include "mle/maintain/kept_parameters.h"

#include <array>
#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "mle/model/element_response.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::array<ParameterEstimate*, 3> ParametersOf(ElementEstimate& element) {
  return {&element.gain, &element.time_scale, &element.delay};
}

bool IsFitted(const ParameterEstimate& parameter) {
  return parameter.standard_error > 0.0 &&
         std::isfinite(parameter.standard_error);
}

bool IsUnchanged(const ParameterEstimate& parameter) {
  return parameter.lower <= parameter.initial &&
         parameter.initial <= parameter.upper;
}

// The parameters of an output, 3m, and which of them are held and which free.
struct Parameters {
  std::vector<ParameterEstimate*> all;
  std::vector<Index> held;
  std::vector<Index> free;
};

Parameters FindParameters(OutputErrorFit& fit, int output) {
  const int m = fit.model.num_inputs();
  Parameters parameters;
  for (int j = 0; j < m; ++j) {
    ElementEstimate& element = fit.elements[output * m + j];
    int changed = 0;
    for (ParameterEstimate* const one : ParametersOf(element)) {
      if (IsFitted(*one) && !IsUnchanged(*one)) ++changed;
    }
    for (ParameterEstimate* const one : ParametersOf(element)) {
      const auto index = static_cast<Index>(parameters.all.size());
      parameters.all.push_back(one);
      if (element.state != ElementState::kFitted || !IsFitted(*one)) continue;
      const bool held = changed > 0 && IsUnchanged(*one);
      (held ? parameters.held : parameters.free).push_back(index);
    }
  }
  return parameters;
}

// Parameter number `index` of the output, less by `shift`: times are not
// negative, and gains keep their signs.
bool IsPossible(OutputErrorFit& fit, int output, Index index, double shift) {
  const auto place =
      static_cast<std::size_t>(output * fit.model.num_inputs() + index / 3);
  const double value = ParametersOf(fit.elements[place])[index % 3]->value;
  const double shifted = value - shift;
  return index % 3 == 2 ? shifted >= 0.0 : value * shifted > 0.0;
}

void KeepUnchanged(OutputErrorFit& fit, int output) {
  const Parameters parameters = FindParameters(fit, output);
  const std::vector<Index>& held = parameters.held;
  const std::vector<Index>& free = parameters.free;
  if (held.empty()) return;
  const MatrixXd& C = fit.covariances[static_cast<std::size_t>(output)];
  const auto count = static_cast<Index>(held.size());
  MatrixXd C_SS(count, count);
  MatrixXd C_FS(static_cast<Index>(free.size()), count);
  VectorXd excess(count);
  for (Index s = 0; s < count; ++s) {
    const auto at = static_cast<std::size_t>(s);
    const ParameterEstimate& parameter = *parameters.all[held[at]];
    excess[s] = parameter.value - parameter.initial;
    for (Index t = 0; t < count; ++t) C_SS(t, s) = C(held[t], held[at]);
    for (Index f = 0; f < C_FS.rows(); ++f) C_FS(f, s) = C(free[f], held[at]);
  }
  const VectorXd shift = C_FS * C_SS.ldlt().solve(excess);
  for (Index f = 0; f < shift.size(); ++f) {
    if (!IsPossible(fit, output, free[f], shift[f])) return;
  }
  for (Index s = 0; s < count; ++s) {
    ParameterEstimate& parameter = *parameters.all[held[s]];
    parameter.value = parameter.initial;
  }
  for (Index f = 0; f < shift.size(); ++f) {
    ParameterEstimate& parameter = *parameters.all[free[f]];
    parameter.value -= shift[f];
    parameter.lower -= shift[f];
    parameter.upper -= shift[f];
  }
  const int m = fit.model.num_inputs();
  for (int j = 0; j < m; ++j) {
    const ElementEstimate& element = fit.elements[output * m + j];
    if (element.state != ElementState::kFitted) continue;
    const auto response = ElementResponse::Create(fit.model.element(output, j));
    if (!response.ok()) continue;
    fit.model.element(output, j) =
        response->ToTransferFunction(element.values());
  }
}

}  // namespace

void KeepUnchangedParameters(OutputErrorFit& fit) {
  for (int i = 0; i < fit.model.num_outputs(); ++i) KeepUnchanged(fit, i);
}

}  // namespace mle
