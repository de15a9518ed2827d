#include "control/first_order.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"

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

}  // namespace

absl::StatusOr<std::vector<FirstOrder>> DescribeAsFirstOrder(
    const StepResponse& response) {
  const int p = response.num_outputs;
  const int m = response.num_inputs;
  if (p < 1 || m < 1 || response.samples() < 2 ||
      !response.values.allFinite()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a step response of ", p, " outputs, ", m, " inputs and ",
        response.samples(),
        " samples cannot be described: at least 1, 1 and 2 finite ones are "
        "needed"));
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
      const double gain = values[values.size() - 1];
      if (gain == 0.0 ||
          (size(i, j) <= kNegligibleResponse * size.row(i).maxCoeff() &&
           size(i, j) <= kNegligibleResponse * size.col(j).maxCoeff())) {
        continue;
      }
      const double early = TimeToReach(values, 1.0 - std::exp(-1.0 / 3.0));
      const double late = TimeToReach(values, 1.0 - std::exp(-1.0));
      FirstOrder& element = elements[static_cast<std::size_t>(i) * m + j];
      element.gain = gain;
      element.time_constant = 1.5 * (late - early) * response.sample_time;
      element.delay =
          std::max(0.0, late * response.sample_time - element.time_constant);
    }
  }
  return elements;
}

}  // namespace mle::control
