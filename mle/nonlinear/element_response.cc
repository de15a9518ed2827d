#include "mle/nonlinear/element_response.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/LU"
#include "glog/logging.h"
#include "mle/base/status.h"
#include "unsupported/Eigen/MatrixFunctions"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// z(τ) = transition z(0) + input u, for ż = M z + n u.
struct HeldMap {
  MatrixXd transition;
  VectorXd input;
};

HeldMap Discretise(const MatrixXd& M, const VectorXd& n, double duration) {
  const Eigen::Index size = M.rows();
  MatrixXd augmented = MatrixXd::Zero(size + 1, size + 1);
  augmented.topLeftCorner(size, size) = duration * M;
  augmented.topRightCorner(size, 1) = duration * n;
  const MatrixXd exponential = augmented.exp();
  return {exponential.topLeftCorner(size, size),
          exponential.topRightCorner(size, 1)};
}

}  // namespace

absl::StatusOr<ElementResponse> ElementResponse::Create(
    const TransferFunction& element) {
  MLE_RETURN_IF_ERROR(element.Validate());
  if (element.IsZero()) {
    return absl::InvalidArgumentError(
        "the element is zero; it has no response to fit");
  }
  if (element.numerator().size() >= element.denominator().size()) {
    return absl::InvalidArgumentError(
        "the element has feedthrough (its numerator is of the denominator's "
        "degree); to fit a dead time it must be strictly proper");
  }
  ElementResponse response;
  const double gain = element.StaticGain();
  const double time_scale = element.SlowestTimeConstant();
  response.initial_ = element;
  response.shape_gain_ = gain != 0.0 ? gain : 1.0;
  response.initial_values_ = {.gain = response.shape_gain_,
                              .time_scale = time_scale,
                              .delay = element.delay()};
  // In the time unit T the state of derivative i is T^i times as large.
  const StateSpace system = element.Realize();
  const Eigen::Index r = system.B.size();
  VectorXd scale(r);
  for (Eigen::Index i = 0; i < r; ++i) {
    scale(i) = std::pow(time_scale, static_cast<double>(i));
  }
  response.A_ = time_scale * (scale.asDiagonal() * system.A *
                              scale.cwiseInverse().asDiagonal());
  response.B_ = time_scale * scale.cwiseProduct(system.B);
  response.C_ = system.C * scale.cwiseInverse().asDiagonal();
  response.C_ /= response.shape_gain_;
  // The output's size belongs to C: states of size 1 then make outputs of it.
  const double size = response.B_.norm();
  response.B_ /= size;
  response.C_ *= size;
  return response;
}

TransferFunction ElementResponse::ToTransferFunction(
    const ElementValues& values) const {
  if (initial_.IsFirstOrder()) {
    return TransferFunction::FirstOrder(values.gain, values.time_scale,
                                        values.delay);
  }
  const double stretch = values.time_scale / initial_values_.time_scale;
  const auto stretched = [stretch](std::vector<double> coefficients) {
    double power = 1.0;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {
      *c *= power;
      power *= stretch;
    }
    return coefficients;
  };
  std::vector<double> numerator = stretched(initial_.numerator());
  for (double& c : numerator) c *= values.gain / shape_gain_;
  return TransferFunction(std::move(numerator),
                          stretched(initial_.denominator()), values.delay);
}

void ElementResponse::Simulate(double time_scale, double sample_time,
                               SampledDelay delay,
                               const Eigen::Ref<const VectorXd>& inputs,
                               double past_input,
                               Eigen::Ref<MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), inputs.size());
  CHECK_EQ(columns.cols(), 3);
  const int r = order();
  // States x and T ∂x/∂T, time in units of T.
  MatrixXd M = MatrixXd::Zero(2 * r, 2 * r);
  M.topLeftCorner(r, r) = A_;
  M.bottomLeftCorner(r, r) = -A_;
  M.bottomRightCorner(r, r) = A_;
  VectorXd n(2 * r);
  n << B_, -B_;
  const double duration = sample_time / time_scale;
  const HeldMap first = Discretise(M, n, delay.fraction * duration);
  const HeldMap rest = Discretise(M, n, (1.0 - delay.fraction) * duration);
  const MatrixXd transition = rest.transition * first.transition;
  const VectorXd by_older = rest.transition * first.input;
  const Eigen::RowVectorXd slope_by_state = -C_ * A_ / time_scale;
  const double slope_by_input = -C_.dot(B_) / time_scale;

  VectorXd state = VectorXd::Zero(2 * r);
  state.head(r) = -A_.partialPivLu().solve(B_) * past_input;
  VectorXd next(2 * r);
  double older = past_input;  // u_{k−q−1}
  for (Eigen::Index k = 0; k < inputs.size(); ++k) {
    columns(k, 0) = C_.dot(state.head(r));
    columns(k, 1) = C_.dot(state.tail(r));
    columns(k, 2) = slope_by_state.dot(state.head(r)) + slope_by_input * older;
    const double newer =
        k >= delay.whole ? inputs(k - delay.whole) : past_input;
    next.noalias() = transition * state;
    state = next + by_older * older + rest.input * newer;
    older = newer;
  }
}

void ElementResponse::FreeResponses(double time_scale, double sample_time,
                                    Eigen::Ref<MatrixXd> columns,
                                    Eigen::Ref<MatrixXd> derivatives) const {
  CHECK_EQ(columns.cols(), order());
  const double duration = sample_time / time_scale;
  const MatrixXd transition = (duration * A_).exp();
  Eigen::RowVectorXd output = C_;
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    columns.row(k) = output;
    derivatives.row(k) = -static_cast<double>(k) * duration * (output * A_);
    output = (output * transition).eval();
  }
}

}  // namespace mle
