#include "control/first_order.h"

#include <algorithm>
#include <cmath>

#include "mle/base/status.h"

namespace mle::control {
namespace {

constexpr double kNegligibleResponse = 0.01;

// When φ/K first reaches `part`, by linear interpolation, in samples.
double TimeToReach(const Eigen::Ref<const Eigen::VectorXd>& response,
                   double part) {
  const double gain = response[response.size() - 1];
  for (Eigen::Index k = 1; k < response.size(); ++k) {
    const double now = response[k] / gain;
    if (now < part) continue;
    const double before = response[k - 1] / gain;
    return static_cast<double>(k) - (now - part) / (now - before);
  }
  return static_cast<double>(response.size() - 1);
}

// K is not 0 and each time in samples.
FirstOrder DescribeSettling(const Eigen::Ref<const Eigen::VectorXd>& response) {
  const double early = TimeToReach(response, 1.0 - std::exp(-1.0 / 3.0));
  const double late = TimeToReach(response, 1.0 - std::exp(-1.0));
  FirstOrder element;
  element.gain = response[response.size() - 1];
  element.time_constant = 1.5 * (late - early);
  element.delay = std::max(0.0, late - element.time_constant);
  return element;
}

FirstOrder DescribeRamp(const Eigen::Ref<const Eigen::VectorXd>& response) {
  const Eigen::Index last = response.size() - 1;
  FirstOrder element;
  element.integrating = true;
  element.gain = response[last] - response[last - 1];
  const double start =
      std::clamp(static_cast<double>(last) - response[last] / element.gain, 0.0,
                 static_cast<double>(last));
  const auto before = static_cast<Eigen::Index>(start);
  const double part = start - static_cast<double>(before);
  const double at_start = (1.0 - part) * response[before] +
                          part * response[std::min(before + 1, last)];
  element.time_constant =
      std::clamp(std::exp(1.0) * at_start / element.gain, 0.0, start);
  element.delay = start - element.time_constant;
  return element;
}

}  // namespace

absl::StatusOr<std::vector<FirstOrder>> DescribeAsFirstOrder(
    const StepResponse& response) {
  const int p = response.num_outputs;
  const int m = response.num_inputs;
  if (p < 1 || m < 1 || response.samples() < 2 ||
      !response.values.allFinite()) {
    return InvalidArgument(
        "a step response of ", p, " outputs, ", m, " inputs and ",
        response.samples(),
        " samples cannot be described: at least 1, 1 and 2 finite ones are "
        "needed");
  }
  Eigen::MatrixXd size(p, m);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      size(i, j) = response.element(i, j).cwiseAbs().maxCoeff();
    }
  }
  std::vector<FirstOrder> elements(static_cast<std::size_t>(p) * m);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      const auto values = response.element(i, j);
      const bool ramp = response.IsIntegrating(i, j);
      const Eigen::Index last = values.size() - 1;
      if (values[last] == (ramp ? values[last - 1] : 0.0) ||
          (size(i, j) <= kNegligibleResponse * size.row(i).maxCoeff() &&
           size(i, j) <= kNegligibleResponse * size.col(j).maxCoeff())) {
        continue;
      }
      FirstOrder& element = elements[static_cast<std::size_t>(i) * m + j];
      element = ramp ? DescribeRamp(values) : DescribeSettling(values);
      element.time_constant *= response.sample_time;
      element.delay *= response.sample_time;
      if (ramp) element.gain /= response.sample_time;
    }
  }
  return elements;
}

}  // namespace mle::control
