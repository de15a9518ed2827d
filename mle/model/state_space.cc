#include "mle/model/state_space.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Eigenvalues"
#include "Eigen/LU"
#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle {
namespace {

absl::Status CheckMatrix(const char* name, const Eigen::MatrixXd& matrix,
                         Eigen::Index rows, Eigen::Index cols) {
  if (matrix.rows() != rows || matrix.cols() != cols) {
    return absl::InvalidArgumentError(
        absl::StrCat("state-space model: ", name, " is ", matrix.rows(), " × ",
                     matrix.cols(), ", must be ", rows, " × ", cols));
  }
  if (!matrix.allFinite()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "state-space model: ", name, " holds an entry that is not finite"));
  }
  return absl::OkStatus();
}

absl::Status CheckDelays(const char* name, const std::vector<int>& delays,
                         int wanted) {
  if (static_cast<int>(delays.size()) != wanted) {
    return absl::InvalidArgumentError(
        absl::StrCat("state-space model: ", name, " has ", delays.size(),
                     " entries, must have ", wanted));
  }
  for (const int delay : delays) {
    if (delay < 0 || delay > kMaxStateSpaceDelay) {
      return absl::InvalidArgumentError(absl::StrCat(
          "state-space model: ", name, " holds ", delay, ", must be from 0 to ",
          kMaxStateSpaceDelay, " samples"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DiscreteStateSpace::Validate() const {
  if (!(sample_time > 0.0) || !std::isfinite(sample_time)) {
    return absl::InvalidArgumentError(
        absl::StrCat("state-space model: sample_time is ", sample_time,
                     ", must be positive"));
  }
  if (order() < 1 || num_inputs() < 1 || num_outputs() < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "state-space model: ", order(), " states, ", num_inputs(), " inputs, ",
        num_outputs(), " outputs; each must be at least 1"));
  }
  MLE_RETURN_IF_ERROR(CheckMatrix("A", A, order(), order()));
  MLE_RETURN_IF_ERROR(CheckMatrix("B", B, order(), num_inputs()));
  MLE_RETURN_IF_ERROR(CheckMatrix("C", C, num_outputs(), order()));
  MLE_RETURN_IF_ERROR(CheckMatrix("D", D, num_outputs(), num_inputs()));
  MLE_RETURN_IF_ERROR(CheckDelays("input_delays", input_delays, num_inputs()));
  MLE_RETURN_IF_ERROR(
      CheckDelays("output_delays", output_delays, num_outputs()));
  const double radius = A.eigenvalues().cwiseAbs().maxCoeff();
  if (!(radius < 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("state-space model: A has an eigenvalue of magnitude ",
                     radius, ", each must be below 1: the model is unstable"));
  }
  return absl::OkStatus();
}

Eigen::MatrixXd DiscreteStateSpace::StaticGains() const {
  const Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(order(), order()) - A;
  return C * inner.partialPivLu().solve(B) + D;
}

StepResponse DiscreteStateSpace::ComputeStepResponse(int samples) const {
  CHECK_GE(samples, 0);
  StepResponse response(sample_time, num_outputs(), num_inputs(), samples);
  Eigen::MatrixXd states = Eigen::MatrixXd::Zero(order(), num_inputs());
  for (int k = 0; k < samples; ++k) {
    const Eigen::MatrixXd outputs = C * states + D;
    for (int i = 0; i < num_outputs(); ++i) {
      for (int j = 0; j < num_inputs(); ++j) {
        const int late = k + input_delays[j] + output_delays[i];
        if (late < samples) response.element(i, j)(late) = outputs(i, j);
      }
    }
    states = (A * states + B).eval();
  }
  return response;
}

Eigen::MatrixXd DiscreteStateSpace::Simulate(
    const Eigen::MatrixXd& inputs) const {
  CHECK_EQ(inputs.rows(), num_inputs());
  const Eigen::Index samples = inputs.cols();
  Eigen::MatrixXd outputs = Eigen::MatrixXd::Zero(num_outputs(), samples);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(order());
  Eigen::VectorXd seen(num_inputs());
  for (Eigen::Index k = 0; k < samples; ++k) {
    for (int j = 0; j < num_inputs(); ++j) {
      const Eigen::Index before = k - input_delays[j];
      seen(j) = before >= 0 ? inputs(j, before) : 0.0;
    }
    const Eigen::VectorXd now = C * state + D * seen;
    for (int i = 0; i < num_outputs(); ++i) {
      const Eigen::Index late = k + output_delays[i];
      if (late < samples) outputs(i, late) = now(i);
    }
    state = (A * state + B * seen).eval();
  }
  return outputs;
}

}  // namespace mle
