#include "sim/signal_step.h"

#include <cmath>

#include "mle/base/status.h"

namespace mle::sim {

absl::Status SignalStep::Validate() const {
  if (std::isfinite(time) && std::isfinite(size) && duration >= 0.0 &&
      std::isfinite(duration)) {
    return absl::OkStatus();
  }
  return InvalidArgument("step: time = ", time, ", size = ", size,
                         ", duration = ", duration,
                         ", but all must be finite and duration ≥ 0");
}

void AddStep(const SignalStep& step, double sample_time,
             Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> signal) {
  for (Eigen::Index k = 0; k < signal.size(); ++k) {
    const double since =
        (static_cast<double>(k) + 1e-9) * sample_time - step.time;
    if (since < 0.0) continue;
    signal[k] +=
        since < step.duration ? step.size * since / step.duration : step.size;
  }
}

}  // namespace mle::sim
