#include "mle/exchange/sampled_responses.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr double kSettled = 1e-4;
constexpr int kManyCoefficients = 600;
constexpr double kMostNumbers = 1e7;

}  // namespace

double SamplesToDecay(double magnitude) {
  return magnitude > 0.0 ? std::log(kSettled) / std::log(magnitude) : 0.0;
}

absl::StatusOr<StepResponseModel> Sample(const SampledModel& model) {
  const int p = model.channels.num_outputs();
  const int m = model.channels.num_inputs();
  const bool ramps = model.ramps.any();
  const double samples = (ramps ? 2.0 : 1.0) * model.samples;
  if (samples * p * m > kMostNumbers) {
    return absl::InvalidArgumentError(absl::StrCat(
        "its slowest mode settles after ", model.samples,
        " samples, too many to describe it; take a longer sample time, or, of "
        "an output that integrates, a pole of exactly 1"));
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
