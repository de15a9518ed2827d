#include "control/operating_cost.h"

#include <algorithm>
#include <cmath>

namespace mle::control {

OperationSums OperationSums::Zero(int num_outputs, int num_inputs) {
  OperationSums sums;
  sums.squared_error = Eigen::VectorXd::Zero(num_outputs);
  sums.absolute_error = sums.squared_error;
  sums.violation = sums.squared_error;
  sums.movement = Eigen::VectorXd::Zero(num_inputs);
  return sums;
}

void OperationSums::Add(const OperationSums& other, double factor) {
  time += factor * other.time;
  squared_error += factor * other.squared_error;
  absolute_error += factor * other.absolute_error;
  violation += factor * other.violation;
  movement += factor * other.movement;
}

OperationSums SumsOf(const Eigen::MatrixXd& outputs,
                     const Eigen::MatrixXd& set_points,
                     const Eigen::MatrixXd& inputs, int first, int end,
                     double sample_time, const OutputLimits& limits) {
  OperationSums sums = OperationSums::Zero(static_cast<int>(outputs.rows()),
                                           static_cast<int>(inputs.rows()));
  sums.time = sample_time * std::max(end - first, 0);
  for (int k = first; k < end; ++k) {
    for (Eigen::Index i = 0; i < outputs.rows(); ++i) {
      const double y = outputs(i, k);
      const double error = std::abs(y - set_points(i, k));
      sums.squared_error[i] += sample_time * error * error;
      sums.absolute_error[i] += sample_time * error;
      sums.violation[i] +=
          sample_time * std::max({0.0, y - limits.max[i], limits.min[i] - y});
    }
    if (k > 0) sums.movement += (inputs.col(k) - inputs.col(k - 1)).cwiseAbs();
  }
  return sums;
}

void Cost::Add(const Cost& other) {
  product += other.product;
  violation += other.violation;
  movement += other.movement;
  test_hours += other.test_hours;
  engineering += other.engineering;
}

Cost CostOf(const OperationSums& sums, const Prices& prices,
            double hours_per_unit) {
  Cost cost;
  cost.product =
      hours_per_unit * (prices.squared_error.dot(sums.squared_error) +
                        prices.absolute_error.dot(sums.absolute_error));
  cost.violation = hours_per_unit * prices.violation.dot(sums.violation);
  cost.movement = prices.movement.dot(sums.movement);
  return cost;
}

}  // namespace mle::control
