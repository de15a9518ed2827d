#include "mle/exchange/state_space_responses.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "Eigen/Eigenvalues"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr double kSettled = 1e-4;
constexpr int kManyCoefficients = 600;
constexpr double kMostNumbers = 1e7;

// A response of at most this share of (samples · norm of the row of C · norm of
// the column of B) is rounding: the input has no effect.
constexpr double kResponseRounding = 1e-13;
// An eigenvalue within this distance of 1 integrates
// (DiscreteStateSpace::Validate()).
constexpr double kIntegrates = 1e-9;

// The largest magnitude of an eigenvalue that does not integrate.
double SlowestMode(const Eigen::MatrixXd& a) {
  double slowest = 0.0;
  for (const std::complex<double> value : a.eigenvalues()) {
    if (std::abs(value - 1.0) <= kIntegrates) continue;
    slowest = std::max(slowest, std::abs(value));
  }
  return slowest;
}

// Samples until every response stands still. A nilpotent A has a response of
// as many samples as there are states.
double SamplesToSettle(const DiscreteStateSpace& system) {
  const auto largest = [](const std::vector<int>& delays) {
    return *std::max_element(delays.begin(), delays.end());
  };
  const double decay = SamplesToDecay(SlowestMode(system.A));
  return std::ceil(std::max(decay, 1.0 * system.order())) +
         largest(system.input_delays) + largest(system.output_delays);
}

absl::Status CheckFeedthrough(const NamedStateSpace& named) {
  const Eigen::MatrixXd& d = named.system.D;
  if (d.isZero(0.0)) return absl::OkStatus();
  Eigen::Index i = 0;
  Eigen::Index j = 0;
  d.cwiseAbs().maxCoeff(&i, &j);
  return InvalidArgument(
      "state-space model: D is ", d(i, j), " for '", named.outputs[i],
      "' from '", named.inputs[j],
      "', but outputs are measured just before the inputs change: D must be "
      "zero");
}

}  // namespace

absl::StatusOr<StepResponseModel> StepResponsesOf(
    const NamedStateSpace& named) {
  MLE_RETURN_IF_ERROR(named.Validate());
  MLE_RETURN_IF_ERROR(CheckFeedthrough(named));
  const DiscreteStateSpace& system = named.system;
  SampledModel model;
  model.channels = named.Channels();
  model.sample_time = system.sample_time;
  model.samples = SamplesToSettle(system);
  model.ramps = (system.Slopes().array() != 0.0).cast<int>();
  model.rounding = kResponseRounding * model.samples *
                   system.C.rowwise().norm() * system.B.colwise().norm();
  model.respond = [&](int samples) {
    return system.ComputeStepResponse(samples);
  };
  absl::StatusOr<StepResponseModel> sampled = Sample(model);
  if (sampled.ok()) return sampled;
  return InvalidArgument("state-space model: ", sampled.status().message());
}

double SamplesToDecay(double magnitude) {
  return magnitude > 0.0 ? std::log(kSettled) / std::log(magnitude) : 0.0;
}

absl::StatusOr<StepResponseModel> Sample(const SampledModel& model) {
  const int p = model.channels.num_outputs();
  const int m = model.channels.num_inputs();
  const bool ramps = model.ramps.any();
  const double samples = (ramps ? 2.0 : 1.0) * model.samples;
  if (samples * p * m > kMostNumbers) {
    return InvalidArgument(
        "its slowest mode settles after ", model.samples,
        " samples, too many to describe it; take a longer sample time, or, of "
        "an output that integrates, a pole of exactly 1");
  }
  const int stride =
      std::max(1, static_cast<int>(std::ceil(samples / kManyCoefficients)));
  const int length = std::max(static_cast<int>(std::ceil(samples / stride)),
                              kFewestCoefficients);
  const StepResponse response = model.respond(stride * length + 1);
  StepResponseModel sampled;
  sampled.channels = model.channels;
  sampled.interval = stride * model.sample_time;
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      PairResponse pair{.output = i,
                        .input = j,
                        .coefficients = {},
                        .is_ramp = model.ramps(i, j) != 0};
      pair.coefficients =
          response.element(i, j)(Eigen::seqN(stride, length, stride));
      if (pair.coefficients.cwiseAbs().maxCoeff() <= model.rounding(i, j)) {
        continue;
      }
      sampled.pairs.push_back(std::move(pair));
    }
  }
  if (sampled.pairs.empty()) {
    return absl::InvalidArgumentError(
        "no input moves an output: all its step responses are zero");
  }
  MLE_RETURN_IF_ERROR(sampled.Validate());
  return sampled;
}

}  // namespace mle
