#include "mle/model/step_response.h"

#include "glog/logging.h"

namespace mle {

StepResponse::StepResponse(double sample_time_, int num_outputs_,
                           int num_inputs_, int samples)
    : sample_time(sample_time_),
      num_outputs(num_outputs_),
      num_inputs(num_inputs_),
      values(Eigen::MatrixXd::Zero(samples, num_outputs_ * num_inputs_)) {}

double SquaredDistance(const StepResponse& a, const StepResponse& b) {
  CHECK_EQ(a.num_outputs, b.num_outputs);
  CHECK_EQ(a.num_inputs, b.num_inputs);
  CHECK_EQ(a.values.rows(), b.values.rows());
  CHECK_EQ(a.values.cols(), b.values.cols());
  return (a.values - b.values).squaredNorm();
}

Eigen::MatrixXd FinalValues(const StepResponse& response) {
  const int p = response.num_outputs;
  const int m = response.num_inputs;
  CHECK_GT(response.samples(), 0);
  Eigen::MatrixXd finals(p, m);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      finals(i, j) = response.element(i, j)(response.samples() - 1);
    }
  }
  return finals;
}

Eigen::MatrixXd ImpulseResponses(const StepResponse& response) {
  const Eigen::Index n = response.values.rows();
  CHECK_GT(n, 0);
  CHECK_GT(response.sample_time, 0.0);
  Eigen::MatrixXd impulses(n, response.values.cols());
  impulses.row(0).setZero();
  impulses.bottomRows(n - 1) =
      (response.values.bottomRows(n - 1) - response.values.topRows(n - 1)) /
      response.sample_time;
  return impulses;
}

Eigen::MatrixXd ImpulsePeakTimes(const StepResponse& response) {
  const int p = response.num_outputs;
  const int m = response.num_inputs;
  const Eigen::MatrixXd impulses = ImpulseResponses(response);
  Eigen::MatrixXd times(p, m);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      Eigen::Index peak = 0;
      impulses.col(i * m + j).cwiseAbs().maxCoeff(&peak);
      times(i, j) = static_cast<double>(peak) * response.sample_time;
    }
  }
  return times;
}

}  // namespace mle
