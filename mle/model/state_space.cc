#include "mle/model/state_space.h"

#include <cmath>
#include <complex>

#include "Eigen/Eigenvalues"
#include "Eigen/LU"
#include "Eigen/SVD"
#include "glog/logging.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// Distance from 1 of an eigenvalue that is 1 to rounding; a mode that is as
// slow takes 10⁹ samples to settle.
constexpr double kIntegrates = 1e-9;
// A slope below this share of the product of norms is 0 but for rounding.
constexpr double kNoSlope = 1e-12;

int CountIntegrating(const Eigen::VectorXcd& eigenvalues) {
  return static_cast<int>(
      ((eigenvalues.array() - 1.0).abs() <= kIntegrates).count());
}

// The last `count` singular vectors of A − I: those of the eigenvalue 1, from
// the right (x) and from the left.
struct IntegratingVectors {
  Eigen::MatrixXd right;  // n × count
  Eigen::MatrixXd left;   // n × count
  double largest = 0.0;   // their largest singular value, relative to the first
};

IntegratingVectors IntegratingVectorsOf(const Eigen::MatrixXd& a, int count) {
  const Eigen::Index n = a.rows();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(
      a - Eigen::MatrixXd::Identity(n, n),
      Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::VectorXd& values = svd.singularValues();
  IntegratingVectors vectors = {svd.matrixV().rightCols(count),
                                svd.matrixU().rightCols(count)};
  if (values(0) > 0.0) vectors.largest = values(n - count) / values(0);
  return vectors;
}

// P, of a valid model with `count` eigenvalues 1.
Eigen::MatrixXd Projector(const Eigen::MatrixXd& a, int count) {
  const IntegratingVectors vectors = IntegratingVectorsOf(a, count);
  const Eigen::MatrixXd inner = vectors.left.transpose() * vectors.right;
  return vectors.right * inner.partialPivLu().solve(vectors.left.transpose());
}

absl::Status CheckEigenvalues(const Eigen::MatrixXd& a) {
  const Eigen::VectorXcd eigenvalues = a.eigenvalues();
  const int integrating = CountIntegrating(eigenvalues);
  for (const std::complex<double> value : eigenvalues) {
    if (std::abs(value) < 1.0 || std::abs(value - 1.0) <= kIntegrates) continue;
    return InvalidArgument(
        "state-space model: A has an eigenvalue of magnitude ", std::abs(value),
        ", each must be below 1, or 1 where an output "
        "integrates: the model is unstable");
  }
  if (integrating == 0 ||
      IntegratingVectorsOf(a, integrating).largest <= kIntegrates) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      "state-space model: A integrates twice, one state that integrates "
      "another; an output may integrate once (a level, a pressure, an "
      "inventory)");
}

absl::Status CheckMatrix(const char* name, const Eigen::MatrixXd& matrix,
                         Eigen::Index rows, Eigen::Index cols) {
  if (matrix.rows() != rows || matrix.cols() != cols) {
    return InvalidArgument("state-space model: ", name, " is ", matrix.rows(),
                           " × ", matrix.cols(), ", must be ", rows, " × ",
                           cols);
  }
  if (!matrix.allFinite()) {
    return InvalidArgument("state-space model: ", name,
                           " holds an entry that is not finite");
  }
  return absl::OkStatus();
}

absl::Status CheckDelays(const char* name, const std::vector<int>& delays,
                         int wanted) {
  if (static_cast<int>(delays.size()) != wanted) {
    return InvalidArgument("state-space model: ", name, " has ", delays.size(),
                           " entries, must have ", wanted);
  }
  for (const int delay : delays) {
    if (delay < 0 || delay > kMaxStateSpaceDelay) {
      return InvalidArgument("state-space model: ", name, " holds ", delay,
                             ", must be from 0 to ", kMaxStateSpaceDelay,
                             " samples");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DisturbanceForm::Validate(int num_outputs) const {
  const Eigen::Index n = A.rows();
  const Eigen::Index p = num_outputs;
  if (n < 1 || A.cols() != n || C.rows() != p || C.cols() != n ||
      K.rows() != n || K.cols() != p || Q.rows() != n || Q.cols() != n ||
      R.size() != p) {
    return InvalidArgument(
        "disturbance_model: with ", n, " states and ", p,
        " outputs A must be n × n, C p × n, K n × p, Q n × n and R p long");
  }
  if (!A.allFinite() || !C.allFinite() || !K.allFinite() || !Q.allFinite() ||
      !R.allFinite() || (R.array() < 0.0).any()) {
    return absl::InvalidArgumentError(
        "disturbance_model: entries must be finite, those of R not negative");
  }
  const Eigen::MatrixXd of_errors = A - K * C;
  const double radius = of_errors.eigenvalues().cwiseAbs().maxCoeff();
  if (radius < 1.0) return absl::OkStatus();
  return InvalidArgument(
      "disturbance_model: A − K C has an eigenvalue of magnitude ", radius,
      ", each must be below 1: errors of the filter would grow");
}

absl::Status DiscreteStateSpace::Validate() const {
  MLE_RETURN_IF_ERROR(
      ValidateSampleTime("state-space model: sample_time", sample_time));
  if (order() < 1 || num_inputs() < 1 || num_outputs() < 1) {
    return InvalidArgument("state-space model: ", order(), " states, ",
                           num_inputs(), " inputs, ", num_outputs(),
                           " outputs; each must be at least 1");
  }
  MLE_RETURN_IF_ERROR(CheckMatrix("A", A, order(), order()));
  MLE_RETURN_IF_ERROR(CheckMatrix("B", B, order(), num_inputs()));
  MLE_RETURN_IF_ERROR(CheckMatrix("C", C, num_outputs(), order()));
  MLE_RETURN_IF_ERROR(CheckMatrix("D", D, num_outputs(), num_inputs()));
  MLE_RETURN_IF_ERROR(CheckDelays("input_delays", input_delays, num_inputs()));
  MLE_RETURN_IF_ERROR(
      CheckDelays("output_delays", output_delays, num_outputs()));
  return CheckEigenvalues(A);
}

bool DiscreteStateSpace::IsIntegrating() const {
  return CountIntegrating(A.eigenvalues()) > 0;
}

Eigen::MatrixXd DiscreteStateSpace::Slopes() const {
  if (order() == 0) return Eigen::MatrixXd::Zero(num_outputs(), num_inputs());
  const int count = CountIntegrating(A.eigenvalues());
  if (count == 0) return Eigen::MatrixXd::Zero(num_outputs(), num_inputs());
  const Eigen::MatrixXd projector = Projector(A, count);
  Eigen::MatrixXd slopes = C * projector * B / sample_time;
  const Eigen::MatrixXd rounding = kNoSlope * projector.norm() / sample_time *
                                   C.rowwise().norm() * B.colwise().norm();
  return (slopes.cwiseAbs().array() <= rounding.array()).select(0.0, slopes);
}

Eigen::MatrixXd DiscreteStateSpace::StaticGains() const {
  if (order() == 0) return D;  // there are no eigenvalues of an empty matrix
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(order(), order());
  const int count = CountIntegrating(A.eigenvalues());
  if (count == 0) return C * (identity - A).partialPivLu().solve(B) + D;
  const Eigen::MatrixXd projector = Projector(A, count);
  const Eigen::MatrixXd settling = C * (identity - A + projector)
                                           .partialPivLu()
                                           .solve((identity - projector) * B) +
                                   D;
  const Eigen::MatrixXd slopes = Slopes();
  return (slopes.array() == 0.0).select(settling, slopes);
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
