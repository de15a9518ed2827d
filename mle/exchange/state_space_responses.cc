#include "mle/exchange/state_space_responses.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Eigenvalues"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr double kSettled = 1e-4;
constexpr int kManyCoefficients = 600;
constexpr double kMostNumbers = 1e7;
// Of what state and matrices could give: what is rounding of a pair without
// effect.
constexpr double kRounding = 1e-13;

double SlowestMode(const Eigen::MatrixXd& a) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(a, /*computeEigenvectors=*/false)
      .eigenvalues()
      .cwiseAbs()
      .maxCoeff();
}

// Samples until every response stands still. A nilpotent A has a response of
// as many samples as there are states.
double SamplesToSettle(const DiscreteStateSpace& system) {
  const auto largest = [](const std::vector<int>& delays) {
    return *std::max_element(delays.begin(), delays.end());
  };
  const double mode = SlowestMode(system.A);
  const double decay = mode > 0.0 ? std::log(kSettled) / std::log(mode) : 0.0;
  return std::ceil(std::max(decay, 1.0 * system.order())) +
         largest(system.input_delays) + largest(system.output_delays);
}

ProcessModel ChannelsOf(const NamedStateSpace& named) {
  std::vector<InputChannel> inputs;
  for (const std::string& name : named.inputs) inputs.push_back({name, ""});
  std::vector<OutputChannel> outputs;
  for (const std::string& name : named.outputs) {
    outputs.push_back({name, ""});
  }
  return {named.name, named.time_unit, std::move(inputs), std::move(outputs)};
}

absl::Status CheckFeedthrough(const NamedStateSpace& named) {
  const Eigen::MatrixXd& d = named.system.D;
  if (d.isZero(0.0)) return absl::OkStatus();
  Eigen::Index i = 0;
  Eigen::Index j = 0;
  d.cwiseAbs().maxCoeff(&i, &j);
  return absl::InvalidArgumentError(absl::StrCat(
      "state-space model: D is ", d(i, j), " for '", named.outputs[i],
      "' from '", named.inputs[j],
      "', but outputs are measured just before the inputs change: D must be "
      "zero"));
}

}  // namespace

absl::StatusOr<StepResponseModel> StepResponsesOf(
    const NamedStateSpace& named) {
  MLE_RETURN_IF_ERROR(named.Validate());
  MLE_RETURN_IF_ERROR(CheckFeedthrough(named));
  const DiscreteStateSpace& system = named.system;
  const double samples = SamplesToSettle(system);
  if (samples * system.num_outputs() * system.num_inputs() > kMostNumbers) {
    return absl::InvalidArgumentError(absl::StrCat(
        "state-space model: its slowest mode settles after ", samples,
        " samples, too many to describe it; take a longer sample time"));
  }
  const int stride =
      std::max(1, static_cast<int>(std::ceil(samples / kManyCoefficients)));
  const int length = std::max(static_cast<int>(std::ceil(samples / stride)),
                              kFewestCoefficients);
  const StepResponse response = system.ComputeStepResponse(stride * length + 1);
  StepResponseModel model;
  model.channels = ChannelsOf(named);
  model.interval = stride * system.sample_time;
  for (int i = 0; i < system.num_outputs(); ++i) {
    for (int j = 0; j < system.num_inputs(); ++j) {
      PairResponse pair{.output = i, .input = j, .coefficients = {}};
      pair.coefficients =
          response.element(i, j)(Eigen::seqN(stride, length, stride));
      const double rounding =
          kRounding * samples * system.C.row(i).norm() * system.B.col(j).norm();
      if (pair.coefficients.cwiseAbs().maxCoeff() <= rounding) continue;
      model.pairs.push_back(std::move(pair));
    }
  }
  MLE_RETURN_IF_ERROR(model.Validate());
  return model;
}

}  // namespace mle
