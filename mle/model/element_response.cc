#include "mle/model/element_response.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/LU"
#include "glog/logging.h"
#include "mle/base/status.h"
#include "mle/model/held_input_map.h"

namespace mle {

using Eigen::MatrixXd;
using Eigen::VectorXd;

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
  // In the time unit T, with B as it is.
  const StateSpace system = element.Realize();
  response.A_ = time_scale * system.A;
  response.B_ = system.B;
  response.C_ = time_scale / response.shape_gain_ * system.C;
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
  const SampleMap map = SampleMap::Over(duration, delay.fraction, M, n);
  const Eigen::RowVectorXd slope_by_state = -C_ * A_ / time_scale;
  const double slope_by_input = -C_.dot(B_) / time_scale;

  VectorXd state = VectorXd::Zero(2 * r);
  state.head(r) = -A_.partialPivLu().solve(B_) * past_input;
  VectorXd move(2 * r);
  double older = past_input;  // u_{k−q−1}
  for (Eigen::Index k = 0; k < inputs.size(); ++k) {
    columns(k, 0) = C_.dot(state.head(r));
    columns(k, 1) = C_.dot(state.tail(r));
    columns(k, 2) = slope_by_state.dot(state.head(r)) + slope_by_input * older;
    const double newer =
        k >= delay.whole ? inputs(k - delay.whole) : past_input;
    move.setZero();
    move.noalias() += map.E * state;
    move += map.older * older + map.newer * newer;
    state += move;
    older = newer;
  }
}

void ElementResponse::FreeResponses(double time_scale, double sample_time,
                                    Eigen::Ref<MatrixXd> columns,
                                    Eigen::Ref<MatrixXd> derivatives) const {
  CHECK_EQ(columns.cols(), order());
  const double duration = sample_time / time_scale;
  const MatrixXd E = HeldInputMap::Over(duration, A_, B_).E;
  Eigen::RowVectorXd output = C_;
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    columns.row(k) = output;
    derivatives.row(k) = -static_cast<double>(k) * duration * (output * A_);
    output += (output * E).eval();
  }
}

}  // namespace mle
