#include "control/mpc.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSettlingRemainder = 1e-11;  // of the gain
constexpr double kMaxStepResponseValues = 1e8;

absl::Status ValidateWeight(const MatrixXd& weight, int size, const char* name,
                            const char* channels) {
  if (weight.rows() != size || weight.cols() != size) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, " is ", weight.rows(), " × ", weight.cols(), ", but it must be ",
        size, " × ", size, ", one row for each of the ", channels));
  }
  if (!weight.allFinite()) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " has values that are not finite"));
  }
  const double tolerance = 1e-12 * weight.cwiseAbs().maxCoeff();
  const double asymmetry = (weight - weight.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > tolerance) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " differs from its transpose by up to ", asymmetry,
                     ", but it must be symmetric"));
  }
  const double smallest =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(weight, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .minCoeff();
  if (smallest < -tolerance * size) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " has the eigenvalue ", smallest,
                     ", but it must be positive semi-definite"));
  }
  return absl::OkStatus();
}

// The time in which what remains of a step response falls to about `remainder`
// of the gain. r equal real modes of time constant T leave
// e^{−x} Σ_{k<r} x^k/k! after xT, and modes further apart leave less.
double SettlingTime(const TransferFunction& element, double remainder) {
  const double T = element.SlowestTimeConstant();
  if (T == 0.0) return element.delay();
  const int order = static_cast<int>(element.denominator().size()) - 1;
  double x = 0.0;
  for (double left = 1.0; left > remainder;) {
    x += 1.0;
    left = 0.0;
    for (int k = order - 1; k >= 0; --k) left = left * x / (k + 1) + 1.0;
    left *= std::exp(-x);
  }
  return element.delay() + x * T;
}

// Control periods after which the whole model has settled.
double SettlingPeriods(const ProcessModel& model, double control_period) {
  double longest = 0.0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& element = model.element(i, j);
      if (element.IsZero()) continue;
      longest = std::max(longest, SettlingTime(element, kSettlingRemainder));
    }
  }
  return std::ceil(longest / control_period) + 1.0;
}

// S_0; …; S_{samples−1}, one below the other, for the given inputs.
MatrixXd StackStepResponses(const ProcessModel& model,
                            const std::vector<int>& inputs,
                            double control_period, int samples) {
  const int p = model.num_outputs();
  const StepResponse responses =
      model.ComputeStepResponse(control_period, samples);
  MatrixXd stacked(p * samples, inputs.size());
  for (std::size_t j = 0; j < inputs.size(); ++j) {
    for (int i = 0; i < p; ++i) {
      for (int k = 0; k < samples; ++k) {
        stacked(k * p + i, j) = responses.element(i, inputs[j])[k];
      }
    }
  }
  return stacked;
}

// The effect of the moves on the predicted outputs: block (i, j) is S_{i−j},
// i = 1 … H_p, j = 1 … H_c.
MatrixXd DynamicMatrix(const MatrixXd& step_responses, int p, int H_p,
                       int H_c) {
  const Eigen::Index m = step_responses.cols();
  MatrixXd dynamic = MatrixXd::Zero(p * H_p, m * H_c);
  for (int j = 0; j < H_c; ++j) {
    const int rows = p * (H_p - j);
    dynamic.block(p * j, m * j, rows, m) = step_responses.topRows(rows);
  }
  return dynamic;
}

// The first m rows of (GᵀQG + R)⁻¹GᵀQ, Q and R block-diagonal.
absl::StatusOr<MatrixXd> FirstMoveGain(const MatrixXd& dynamic,
                                       const MatrixXd& output_weight,
                                       const MatrixXd& move_weight) {
  const Eigen::Index p = output_weight.rows();
  const Eigen::Index m = move_weight.rows();
  MatrixXd weighted(dynamic.cols(), dynamic.rows());  // GᵀQ
  for (Eigen::Index row = 0; row < dynamic.rows(); row += p) {
    weighted.middleCols(row, p).noalias() =
        dynamic.middleRows(row, p).transpose() * output_weight;
  }
  MatrixXd hessian = weighted * dynamic;
  for (Eigen::Index row = 0; row < hessian.rows(); row += m) {
    hessian.block(row, row, m, m) += move_weight;
  }
  hessian = 0.5 * (hessian + hessian.transpose()).eval();

  // Scaled to a unit diagonal, so that the test below and the solution do not
  // depend on the units of the inputs.
  const VectorXd diagonal = hessian.diagonal();
  double smallest = 0.0;
  VectorXd scale;
  if (diagonal.minCoeff() > 0.0) {
    scale = diagonal.cwiseSqrt().cwiseInverse();
    hessian = scale.asDiagonal() * hessian * scale.asDiagonal();
    smallest =
        Eigen::SelfAdjointEigenSolver<MatrixXd>(hessian, Eigen::EigenvaluesOnly)
            .eigenvalues()
            .minCoeff();
  }
  if (!(smallest > 1e-14 * static_cast<double>(hessian.rows()))) {
    return absl::InvalidArgumentError(
        "the weights do not determine the moves: the Hessian of the control "
        "problem is not positive definite; make move_weight positive definite");
  }
  const MatrixXd solution =
      Eigen::LLT<MatrixXd>(hessian).solve(scale.asDiagonal() * weighted);
  return MatrixXd(scale.head(m).asDiagonal() * solution.topRows(m));
}

}  // namespace

absl::Status MpcOptions::Validate(int num_outputs, int num_inputs) const {
  if (!(control_period > 0.0) || !std::isfinite(control_period)) {
    return absl::InvalidArgumentError(
        absl::StrCat("control_period = ", control_period,
                     ", but it must be finite and > 0"));
  }
  if (control_horizon < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "control_horizon = ", control_horizon, ", but it must be ≥ 1"));
  }
  if (prediction_horizon < control_horizon) {
    return absl::InvalidArgumentError(absl::StrCat(
        "prediction_horizon = ", prediction_horizon,
        ", but it must be at least control_horizon = ", control_horizon));
  }
  if (!(disturbance_variance_ratio >= 0.0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "disturbance_variance_ratio = ", disturbance_variance_ratio,
        ", but it must be ≥ 0"));
  }
  MLE_RETURN_IF_ERROR(
      ValidateWeight(output_weight, num_outputs, "output_weight", "outputs"));
  return ValidateWeight(move_weight, num_inputs, "move_weight", "inputs");
}

Mpc::Mpc(int num_outputs, int num_inputs, double disturbance_variance_ratio)
    : num_outputs_(num_outputs),
      num_inputs_(num_inputs),
      observer_(num_outputs, disturbance_variance_ratio) {}

absl::StatusOr<Mpc> Mpc::Create(const ProcessModel& model,
                                const MpcOptions& options) {
  MLE_RETURN_IF_ERROR(model.Validate());
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  MLE_RETURN_IF_ERROR(options.Validate(p, m));
  Mpc mpc(p, m, options.disturbance_variance_ratio);
  for (int j = 0; j < m; ++j) {
    if (model.inputs()[j].role == InputRole::kManipulated) {
      mpc.manipulated_.push_back(j);
    }
  }
  if (mpc.manipulated_.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the model '", model.name(),
        "' has no manipulated input, so there is nothing to control it with"));
  }

  const double periods =
      std::max(SettlingPeriods(model, options.control_period),
               static_cast<double>(options.prediction_horizon));
  if ((periods + 1.0) * p * m > kMaxStepResponseValues) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the model '", model.name(), "' settles in ", periods,
        " control periods of ", options.control_period, ": too many for its ",
        p, " × ", m,
        " step responses to be kept; use a longer control_period"));
  }
  mpc.step_responses_ =
      StackStepResponses(model, mpc.manipulated_, options.control_period,
                         static_cast<int>(periods) + 1);
  MLE_ASSIGN_OR_RETURN(
      mpc.gain_,
      FirstMoveGain(
          DynamicMatrix(mpc.step_responses_, p, options.prediction_horizon,
                        options.control_horizon),
          options.output_weight,
          options.move_weight(mpc.manipulated_, mpc.manipulated_)));
  mpc.free_response_ = VectorXd::Zero(mpc.step_responses_.rows());
  mpc.inputs_ = VectorXd::Zero(mpc.gain_.rows());
  mpc.move_ = VectorXd::Zero(mpc.gain_.rows());
  mpc.error_ = VectorXd::Zero(mpc.gain_.cols());
  return mpc;
}

void Mpc::Step(const Eigen::Ref<const VectorXd>& measured_outputs,
               const Eigen::Ref<const VectorXd>& set_points,
               Eigen::Ref<VectorXd> next_inputs) {
  const int p = num_outputs_;
  CHECK_EQ(measured_outputs.size(), p);
  CHECK_EQ(set_points.size(), p);
  CHECK_EQ(next_inputs.size(), num_inputs_);

  observer_.Update(measured_outputs, free_response_.head(p));
  for (Eigen::Index row = 0; row < error_.size(); row += p) {
    error_.segment(row, p) = set_points - free_response_.segment(row + p, p) -
                             observer_.disturbance();
  }
  move_.noalias() = gain_ * error_;
  inputs_ += move_;
  next_inputs.setZero();
  for (std::size_t j = 0; j < manipulated_.size(); ++j) {
    next_inputs[manipulated_[j]] = inputs_[j];
  }

  // On to the next instant, from which the move acts. The model has settled
  // beyond the last one.
  std::copy(free_response_.begin() + p, free_response_.end(),
            free_response_.begin());
  free_response_.noalias() += step_responses_ * move_;
}

}  // namespace mle::control
