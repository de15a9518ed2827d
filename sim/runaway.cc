#include "sim/runaway.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"

namespace mle::sim {
namespace {

using Eigen::VectorXd;

constexpr double kRunawayFactor = 1e6;

template <typename Channel>
absl::Status CheckWithin(const std::vector<Channel>& channels,
                         const VectorXd& values, const VectorXd& limits,
                         const char* kind, double time) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && std::abs(values[i]) <= limits[i]) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "the closed loop runs away: ", kind, " '", channels[i].name, "' is ",
        values[i], " at time ", time, ", beyond ±", limits[i],
        "; the controller does not stabilise this plant"));
  }
  return absl::OkStatus();
}

}  // namespace

RunawayGuard::RunawayGuard(const ProcessModel& channels, VectorXd output_sizes)
    : channels_(channels), input_limits_(channels.num_inputs()) {
  VectorXd size = std::move(output_sizes);
  if (size.maxCoeff() == 0.0) size.setOnes();
  output_limits_ = size;
  for (int j = 0; j < channels.num_inputs(); ++j) {
    double input_size = 0.0;
    bool has_effect = false;
    for (int i = 0; i < channels.num_outputs(); ++i) {
      const double gain = std::abs(channels.element(i, j).StaticGain());
      if (gain == 0.0) continue;
      has_effect = true;
      input_size = std::max(input_size, size[i] / gain);
    }
    input_limits_[j] = has_effect ? kRunawayFactor * input_size
                                  : std::numeric_limits<double>::infinity();
    for (int i = 0; i < channels.num_outputs(); ++i) {
      const double gain = std::abs(channels.element(i, j).StaticGain());
      output_limits_[i] = std::max(output_limits_[i], gain * input_size);
    }
  }
  for (double& limit : output_limits_) {
    limit = limit > 0.0 ? kRunawayFactor * limit
                        : std::numeric_limits<double>::infinity();
  }
}

absl::Status RunawayGuard::CheckOutputs(const VectorXd& outputs,
                                        double time) const {
  return CheckWithin(channels_.outputs(), outputs, output_limits_, "output",
                     time);
}

absl::Status RunawayGuard::CheckInputs(const VectorXd& inputs,
                                       double time) const {
  return CheckWithin(channels_.inputs(), inputs, input_limits_, "input", time);
}

}  // namespace mle::sim
