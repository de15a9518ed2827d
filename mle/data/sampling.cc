#include "mle/data/sampling.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr double kMaxSamples = 1e9;

}  // namespace

absl::Status ValidateSampling(double sample_time, double duration) {
  MLE_RETURN_IF_ERROR(ValidateSampleTime("sample_time", sample_time));
  if (!(duration > 0.0) || !std::isfinite(duration)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "duration = ", duration, ", but it must be finite and > 0"));
  }
  if (duration / sample_time >= kMaxSamples) {
    return absl::InvalidArgumentError(
        absl::StrCat("duration = ", duration, " is ", duration / sample_time,
                     " samples of sample_time = ", sample_time,
                     ", but at most ", kMaxSamples, " are supported"));
  }
  return absl::OkStatus();
}

absl::Status ValidateNoiseVariance(double noise_variance) {
  if (!(noise_variance >= 0.0) || !std::isfinite(noise_variance)) {
    return absl::InvalidArgumentError(
        absl::StrCat("noise_variance = ", noise_variance,
                     ", but it must be finite and ≥ 0"));
  }
  return absl::OkStatus();
}

int SampleCount(double sample_time, double duration) {
  return static_cast<int>(std::floor(duration / sample_time + 1e-6)) + 1;
}

}  // namespace mle
