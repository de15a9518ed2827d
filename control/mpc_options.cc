#include "control/mpc_options.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Eigenvalues"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

absl::Status ValidateWeight(const MatrixXd& weight, int size, const char* name,
                            const char* channels) {
  if (weight.rows() != size || weight.cols() != size) {
    return InvalidArgument(name, " is ", weight.rows(), " × ", weight.cols(),
                           ", but it must be ", size, " × ", size,
                           ", one row for each of the ", channels);
  }
  if (!weight.allFinite()) {
    return InvalidArgument(name, " has values that are not finite");
  }
  const double tolerance = 1e-12 * weight.cwiseAbs().maxCoeff();
  const double asymmetry = (weight - weight.transpose()).cwiseAbs().maxCoeff();
  if (!(asymmetry <= tolerance)) {
    return InvalidArgument(name, " differs from its transpose by up to ",
                           asymmetry, ", but it must be symmetric");
  }
  const double smallest =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(weight, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .minCoeff();
  if (!(smallest >= -tolerance * size)) {
    return InvalidArgument(name, " has the eigenvalue ", smallest,
                           ", but it must be positive semi-definite");
  }
  return absl::OkStatus();
}

// Empty, or `size` values of at least `least`.
absl::Status ValidateVector(const VectorXd& values, int size, double least,
                            const char* name) {
  if (values.size() == 0) return absl::OkStatus();
  if (values.size() != size) {
    return InvalidArgument(name, " has ", values.size(),
                           " values, but it must have ", size, " or none");
  }
  for (int i = 0; i < size; ++i) {
    if (!(values[i] >= least)) {
      return InvalidArgument(name, "[", i, "] = ", values[i],
                             std::isinf(least) ? ", but it must be a number"
                                               : ", but it must be ≥ 0");
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateRange(const VectorXd& least, const VectorXd& greatest,
                           int size, const char* least_name,
                           const char* greatest_name) {
  MLE_RETURN_IF_ERROR(ValidateVector(least, size, -kInfinity, least_name));
  MLE_RETURN_IF_ERROR(
      ValidateVector(greatest, size, -kInfinity, greatest_name));
  for (int i = 0; i < size; ++i) {
    const double low = least.size() > 0 ? least[i] : -kInfinity;
    const double high = greatest.size() > 0 ? greatest[i] : kInfinity;
    if (!(low <= high) || low == kInfinity || high == -kInfinity) {
      return InvalidArgument(least_name, "[", i, "] = ", low, " and ",
                             greatest_name, "[", i, "] = ", high,
                             " leave no value between them");
    }
  }
  return absl::OkStatus();
}

// The dynamic matrix has p H_p rows and m M columns, the quadratic program m M
// moves.
absl::Status ValidateSize(const MpcOptions& options, int num_outputs,
                          int num_inputs) {
  constexpr double kMostValues = 1e8;
  const double M = options.block_lengths.empty()
                       ? options.control_horizon
                       : static_cast<double>(options.block_lengths.size());
  const double moves = num_inputs * M;
  const double rows =
      static_cast<double>(options.prediction_horizon) * num_outputs;
  if (std::max(rows, moves) * moves <= kMostValues) return absl::OkStatus();
  return InvalidArgument("prediction_horizon = ", options.prediction_horizon,
                         " with ", M, " moves is too long: ", num_outputs,
                         " outputs and ", num_inputs, " inputs make ",
                         std::max(rows, moves), " by ", moves,
                         " values; at most ", kMostValues, " are supported");
}

}  // namespace

absl::Status MpcLimits::Validate(int num_outputs, int num_inputs) const {
  MLE_RETURN_IF_ERROR(ValidateRange(min_input, max_input, num_inputs,
                                    "min_input", "max_input"));
  MLE_RETURN_IF_ERROR(ValidateVector(max_move, num_inputs, 0.0, "max_move"));
  MLE_RETURN_IF_ERROR(ValidateRange(min_output, max_output, num_outputs,
                                    "min_output", "max_output"));
  MLE_RETURN_IF_ERROR(
      ValidateVector(output_limit_cost, num_outputs, 0.0, "output_limit_cost"));
  for (int i = 0; i < num_outputs; ++i) {
    const bool limited =
        (min_output.size() > 0 && std::isfinite(min_output[i])) ||
        (max_output.size() > 0 && std::isfinite(max_output[i]));
    if (!limited) continue;
    const double cost =
        output_limit_cost.size() > 0 ? output_limit_cost[i] : 0.0;
    if (!(cost > 0.0) || !std::isfinite(cost)) {
      return InvalidArgument("output ", i,
                             " has a limit, but output_limit_cost[", i, "] is ",
                             cost, "; it must be finite and > 0");
    }
  }
  return absl::OkStatus();
}

absl::Status MpcOptions::Validate(int num_outputs, int num_inputs) const {
  if (!(control_period > 0.0) || !std::isfinite(control_period)) {
    return InvalidArgument("control_period = ", control_period,
                           ", but it must be finite and > 0");
  }
  if (block_lengths.empty() && control_horizon < 1) {
    return InvalidArgument("control_horizon = ", control_horizon,
                           ", but it must be ≥ 1");
  }
  if (block_lengths.empty() && prediction_horizon < control_horizon) {
    return InvalidArgument(
        "prediction_horizon = ", prediction_horizon,
        ", but it must be at least control_horizon = ", control_horizon);
  }
  MLE_RETURN_IF_ERROR(ValidateSize(*this, num_outputs, num_inputs));
  double together = 0.0;
  for (const int length : block_lengths) {
    if (length < 1) {
      return InvalidArgument("block_lengths has the value ", length,
                             ", but each must be ≥ 1");
    }
    together += length;
  }
  if (together > prediction_horizon) {
    return InvalidArgument(
        "block_lengths are ", together,
        " together, but prediction_horizon = ", prediction_horizon);
  }
  if (!(disturbance_variance_ratio >= 0.0)) {
    return InvalidArgument("disturbance_variance_ratio = ",
                           disturbance_variance_ratio, ", but it must be ≥ 0");
  }
  MLE_RETURN_IF_ERROR(ValidateVector(disturbance_variance_ratios, num_outputs,
                                     0.0, "disturbance_variance_ratios"));
  if (disturbance_model.has_value()) {
    MLE_RETURN_IF_ERROR(disturbance_model->Validate(num_outputs));
  }
  MLE_RETURN_IF_ERROR(
      ValidateWeight(output_weight, num_outputs, "output_weight", "outputs"));
  MLE_RETURN_IF_ERROR(
      ValidateWeight(move_weight, num_inputs, "move_weight", "inputs"));
  return limits.Validate(num_outputs, num_inputs);
}

std::vector<int> MpcOptions::MoveInstants() const {
  std::vector<int> instants;
  if (block_lengths.empty()) {
    for (int j = 1; j <= control_horizon; ++j) instants.push_back(j);
    return instants;
  }
  int instant = 1;
  for (const int length : block_lengths) {
    instants.push_back(instant);
    instant += length;
  }
  return instants;
}

VectorXd MpcOptions::VarianceRatios(int num_outputs) const {
  if (disturbance_variance_ratios.size() > 0) {
    return disturbance_variance_ratios;
  }
  return VectorXd::Constant(num_outputs, disturbance_variance_ratio);
}

}  // namespace mle::control
