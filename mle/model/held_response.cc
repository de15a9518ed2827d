#include "mle/model/held_response.h"

#include <algorithm>
#include <cmath>

#include "mle/base/number_range.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr double kDelaySnap = 1e-9;  // of Δt
constexpr double kMaxDelaySamples = 1e7;

}  // namespace

absl::StatusOr<HeldResponse> HeldResponse::Create(
    const TransferFunction& element, double sample_time) {
  MLE_RETURN_IF_ERROR(ValidateSampleTime("sample_time", sample_time));
  MLE_RETURN_IF_ERROR(element.Validate());
  const double delay = element.delay() / sample_time;
  if (delay > kMaxDelaySamples) {
    return InvalidArgument("the delay of ", element.delay(), " is more than ",
                           kMaxDelaySamples, " samples of ", sample_time,
                           "; use a longer sample time");
  }
  const double whole = std::floor(delay + kDelaySnap);
  double fraction = std::max(0.0, delay - whole);  // f
  if (fraction < kDelaySnap) fraction = 0.0;

  const StateSpace system = element.Realize();
  HeldResponse response;
  response.whole_delay = static_cast<int>(whole);
  response.map = SampleMap::Over(sample_time, fraction, system.A, system.B);
  response.C = system.C;
  response.D = system.D;
  if (!response.map.E.allFinite() || !response.map.older.allFinite() ||
      !response.map.newer.allFinite()) {
    return InvalidArgument("its response over a sample of ", sample_time,
                           " overflows; use another unit of time");
  }
  return response;
}

}  // namespace mle
