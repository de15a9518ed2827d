#include "mle/model/element_response.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
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

namespace {

// Free responses are 0 once they are below this share of their first values.
constexpr double kForgotten = 1e-100;

// Calls `with` with the order as a constant where it is small: the recursions
// then have no sizes to look up.
template <typename With>
void WithOrder(Eigen::Index order, const With& with) {
  if (order == 1) return with(std::integral_constant<int, 1>());
  if (order == 2) return with(std::integral_constant<int, 2>());
  if (order == 3) return with(std::integral_constant<int, 3>());
  with(std::integral_constant<int, Eigen::Dynamic>());
}

// `state`, x or (x, T ∂x/∂T), runs over the inputs.
template <int kStates, int kOrder, bool kDerivatives>
void RunOver(const SampleMap& map, const Eigen::RowVectorXd& C,
             const Eigen::RowVectorXd& slope, double slope_by_input,
             const VectorXd& start, int whole, double past_input,
             const Eigen::Ref<const VectorXd>& inputs,
             Eigen::Ref<MatrixXd> columns) {
  using State = Eigen::Matrix<double, kStates, 1>;
  using Row = Eigen::Matrix<double, 1, kOrder>;
  const Eigen::Index r = C.size();
  const Eigen::Matrix<double, kStates, kStates> E = map.E;
  const State by_older = map.older;
  const State by_newer = map.newer;
  Row output;
  output = C;
  Row slope_by_state;
  slope_by_state = slope;
  State state = start;
  State move = start;
  double older = past_input;  // u_{k−q−1}
  for (Eigen::Index k = 0; k < inputs.size(); ++k) {
    const auto x = state.head(Eigen::fix<kOrder>(static_cast<int>(r)));
    columns(k, 0) = output.dot(x);
    if constexpr (kDerivatives) {
      columns(k, 1) =
          output.dot(state.tail(Eigen::fix<kOrder>(static_cast<int>(r))));
      columns(k, 2) = slope_by_state.dot(x) + slope_by_input * older;
    }
    const double newer = k >= whole ? inputs(k - whole) : past_input;
    move.setZero();
    move.noalias() += E * state;
    move += by_older * older + by_newer * newer;
    state += move;
    older = newer;
  }
}

template <int kOrder>
void RunFree(const MatrixXd& A, const MatrixXd& E, const Eigen::RowVectorXd& C,
             double duration, Eigen::Ref<MatrixXd> columns,
             Eigen::Ref<MatrixXd> derivatives) {
  using Row = Eigen::Matrix<double, 1, kOrder>;
  Eigen::Matrix<double, kOrder, kOrder> rate;
  rate = A;
  Eigen::Matrix<double, kOrder, kOrder> change;
  change = E;
  const double forgotten = kForgotten * C.norm();
  Row output = C;
  Row next = C;
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    if (output.cwiseAbs().maxCoeff() < forgotten) {
      const Eigen::Index rest = columns.rows() - k;
      columns.bottomRows(rest).setZero();
      derivatives.bottomRows(rest).setZero();
      return;
    }
    columns.row(k) = output;
    next.noalias() = output * rate;
    derivatives.row(k) = -static_cast<double>(k) * duration * next;
    next.noalias() = output * change;
    output += next;
  }
}

}  // namespace

void ElementResponse::Simulate(double time_scale, double sample_time,
                               SampledDelay delay,
                               const Eigen::Ref<const VectorXd>& inputs,
                               double past_input,
                               Eigen::Ref<MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), inputs.size());
  const bool derivatives = columns.cols() > 1;
  CHECK_EQ(columns.cols(), derivatives ? 3 : 1);
  const int r = order();
  // States x and T ∂x/∂T, time in units of T.
  MatrixXd M = MatrixXd::Zero(2 * r, 2 * r);
  M.topLeftCorner(r, r) = A_;
  M.bottomLeftCorner(r, r) = -A_;
  M.bottomRightCorner(r, r) = A_;
  VectorXd n(2 * r);
  n << B_, -B_;
  const int states = derivatives ? 2 * r : r;
  const SampleMap map =
      SampleMap::Over(sample_time / time_scale, delay.fraction,
                      M.topLeftCorner(states, states), n.head(states));
  VectorXd start = VectorXd::Zero(states);
  start.head(r) = -A_.partialPivLu().solve(B_) * past_input;
  WithOrder(r, [&](auto order) {
    constexpr int kOrder = decltype(order)::value;
    constexpr int kStates = kOrder == Eigen::Dynamic ? kOrder : 2 * kOrder;
    const auto run = derivatives ? RunOver<kStates, kOrder, true>
                                 : RunOver<kOrder, kOrder, false>;
    run(map, C_, -C_ * A_ / time_scale, -C_.dot(B_) / time_scale, start,
        delay.whole, past_input, inputs, columns);
  });
}

void ElementResponse::FreeResponses(double time_scale, double sample_time,
                                    Eigen::Ref<MatrixXd> columns,
                                    Eigen::Ref<MatrixXd> derivatives) const {
  CHECK_EQ(columns.cols(), order());
  const double duration = sample_time / time_scale;
  const MatrixXd E = HeldInputMap::Over(duration, A_, B_).E;
  WithOrder(order(), [&](auto order) {
    RunFree<decltype(order)::value>(A_, E, C_, duration, columns, derivatives);
  });
}

}  // namespace mle
