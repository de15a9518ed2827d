#include "mle/model/held_response.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/model/held_input_map.h"

namespace mle {
namespace {

constexpr double kDelaySnap = 1e-9;  // of Δt
constexpr double kMaxDelaySamples = 1e7;

}  // namespace

absl::StatusOr<HeldResponse> HeldResponse::Create(
    const TransferFunction& element, double sample_time) {
  if (!(sample_time > 0.0) || !std::isfinite(sample_time)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "sample_time = ", sample_time, ", but it must be finite and > 0"));
  }
  MLE_RETURN_IF_ERROR(element.Validate());
  const double delay = element.delay() / sample_time;
  if (delay > kMaxDelaySamples) {
    return absl::InvalidArgumentError(
        absl::StrCat("the delay of ", element.delay(), " is ", delay,
                     " samples, but at most ", kMaxDelaySamples,
                     " are supported; use a longer sample time"));
  }
  const double whole = std::floor(delay + kDelaySnap);
  double fraction = std::max(0.0, delay - whole);  // f
  if (fraction < kDelaySnap) fraction = 0.0;

  const StateSpace system = element.Realize();
  const HeldInputMap first =
      HeldInputMap::Over(fraction * sample_time, system.A, system.B);
  HeldInputMap rest =
      HeldInputMap::Over((1.0 - fraction) * sample_time, system.A, system.B);
  HeldResponse response;
  response.whole_delay = static_cast<int>(whole);
  response.E = first.E + rest.E + rest.E * first.E;
  response.older = first.gamma + rest.E * first.gamma;
  response.newer = std::move(rest.gamma);
  response.C = system.C;
  response.D = system.D;
  if (!response.E.allFinite() || !response.older.allFinite() ||
      !response.newer.allFinite()) {
    return absl::InvalidArgumentError(
        absl::StrCat("its response over a sample of ", sample_time,
                     " overflows; its fastest mode is too fast for that sample "
                     "time: leave that mode out"));
  }
  return response;
}

}  // namespace mle
