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
        "the closed loop diverges: ", kind, " '", channels[i].name, "' is ",
        std::isfinite(values[i]) ? absl::StrCat(values[i], " at time ", time,
                                                ", beyond ±", limits[i])
                                 : absl::StrCat("not a number at time ", time),
        "; the controller does not stabilise this plant"));
  }
  return absl::OkStatus();
}

}  // namespace

RunawayGuard::RunawayGuard(const ProcessModel& channels, VectorXd output_sizes)
    : channels_(channels) {
  const int p = channels.num_outputs();
  const int m = channels.num_inputs();
  VectorXd outputs = std::move(output_sizes);
  if (outputs.maxCoeff() == 0.0) outputs.setOnes();
  VectorXd inputs = VectorXd::Zero(m);
  // A size reaches one channel further in each round.
  for (bool reached = true; reached;) {
    reached = false;
    for (int j = 0; j < m; ++j) {
      if (inputs[j] > 0.0) continue;
      for (int i = 0; i < p; ++i) {
        const double gain = std::abs(channels.element(i, j).StaticGain());
        if (gain > 0.0) inputs[j] = std::max(inputs[j], outputs[i] / gain);
      }
      reached = reached || inputs[j] > 0.0;
    }
    for (int j = 0; reached && j < m; ++j) {
      for (int i = 0; i < p; ++i) {
        const double gain = std::abs(channels.element(i, j).StaticGain());
        outputs[i] = std::max(outputs[i], gain * inputs[j]);
      }
    }
  }
  const auto limit = [](double size) {
    return size > 0.0 ? kRunawayFactor * size
                      : std::numeric_limits<double>::infinity();
  };
  output_limits_ = outputs.unaryExpr(limit);
  input_limits_ = inputs.unaryExpr(limit);
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
