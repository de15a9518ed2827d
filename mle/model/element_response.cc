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
  response.initial_ = element;
  response.integrating_ = element.IsIntegrating();
  TransferFunction stable = element;
  double time_scale = element.SlowestTimeConstant();
  if (response.integrating_) {
    std::vector<double> denominator = element.denominator();
    denominator.pop_back();
    stable = TransferFunction(element.numerator(), std::move(denominator),
                              element.delay());
    if (time_scale == 0.0) {
      time_scale = element.delay() > 0.0 ? element.delay() : 1.0;
    }
  }
  response.shape_gain_ = gain != 0.0 ? gain : 1.0;
  response.initial_values_ = {.gain = response.shape_gain_,
                              .time_scale = time_scale,
                              .delay = element.delay()};
  // In the time unit T, with B as it is.
  const StateSpace system = stable.Realize();
  response.A_ = time_scale * system.A;
  if (response.order() > 0) {
    response.shortest_time_ =
        1.0 / response.A_.eigenvalues().cwiseAbs().maxCoeff();
  }
  response.B_ = system.B;
  response.C_ = time_scale / response.shape_gain_ * system.C;
  response.D_ = system.D / response.shape_gain_;
  return response;
}

ElementResponse::System ElementResponse::SystemAt(double time_scale) const {
  if (!integrating_) return {A_, B_, C_};
  const int r = order();
  System system = {MatrixXd::Zero(r + 1, r + 1), VectorXd::Zero(r + 1),
                   Eigen::RowVectorXd::Zero(r + 1)};
  system.A.topLeftCorner(r, r) = A_;
  system.A.bottomLeftCorner(1, r) = C_;
  system.B << B_, D_;
  system.C(r) = time_scale;
  return system;
}

TransferFunction ElementResponse::ToTransferFunction(
    const ElementValues& values) const {
  if (initial_.IsFirstOrder()) {
    return TransferFunction::FirstOrder(values.gain, values.time_scale,
                                        values.delay);
  }
  if (initial_.IsIntegratorWithLag()) {
    return TransferFunction::Integrator(
        values.gain, has_time_scale() ? values.time_scale : 0.0, values.delay);
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
  // s itself is stretched too.
  const double factor =
      values.gain / shape_gain_ * (integrating_ ? stretch : 1.0);
  for (double& c : numerator) c *= factor;
  return TransferFunction(std::move(numerator),
                          stretched(initial_.denominator()), values.delay);
}

namespace {

// Free responses are 0 once they are below this share of their first values.
constexpr double kForgottenResponse = 1e-18;

// Calls `with` with the order as a constant where it is small: the recursions
// then have no sizes to look up.
template <typename With>
void WithOrder(Eigen::Index order, const With& with) {
  if (order == 1) return with(std::integral_constant<int, 1>());
  if (order == 2) return with(std::integral_constant<int, 2>());
  if (order == 3) return with(std::integral_constant<int, 3>());
  with(std::integral_constant<int, Eigen::Dynamic>());
}

// `state`, x or (x, T ∂x/∂T), runs over the inputs less `base`.
template <int kStates, int kOrder, bool kDerivatives>
void RunOver(const SampleMap& map, const Eigen::RowVectorXd& C,
             const Eigen::RowVectorXd& slope, double slope_by_input,
             const VectorXd& start, int whole, double past_input, double base,
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
  double older = past_input - base;  // u_{k−q−1}
  for (Eigen::Index k = 0; k < inputs.size(); ++k) {
    const auto x = state.head(Eigen::fix<kOrder>(static_cast<int>(r)));
    columns(k, 0) = output.dot(x);
    if constexpr (kDerivatives) {
      columns(k, 1) =
          output.dot(state.tail(Eigen::fix<kOrder>(static_cast<int>(r))));
      columns(k, 2) = slope_by_state.dot(x) + slope_by_input * older;
    }
    const double newer = (k >= whole ? inputs(k - whole) : past_input) - base;
    // setZero(), of which g++ 12 warns where the library is one source.
    std::fill_n(move.data(), move.size(), 0.0);
    move.noalias() += E * state;
    move += by_older * older + by_newer * newer;
    state += move;
    older = newer;
  }
}

// s_{k+1} = a s_k + g_k from s_0 = `start`: s in place of g. Four samples at a
// time, so that a state does not wait for those between:
//
//   s_{k+4} = a⁴ s_k + a³ g_k + a² g_{k+1} + a g_{k+2} + g_{k+3}.
void Scan(double a, double start, VectorXd& g) {
  const double a2 = a * a;
  const double a3 = a2 * a;
  const double a4 = a2 * a2;
  double state = start;
  Eigen::Index k = 0;
  for (; k + 4 <= g.size(); k += 4) {
    const double g0 = g(k);
    const double g1 = a * g0 + g(k + 1);
    const double g2 = a2 * g0 + (a * g(k + 1) + g(k + 2));
    const double g3 = a2 * g1 + (a * g(k + 2) + g(k + 3));
    g(k) = state;
    g(k + 1) = a * state + g0;
    g(k + 2) = a2 * state + g1;
    g(k + 3) = a3 * state + g2;
    state = a4 * state + g3;
  }
  for (; k < g.size(); ++k) {
    const double next = a * state + g(k);
    g(k) = state;
    state = next;
  }
}

// RunOver() of first order.
template <bool kDerivatives>
void RunFirstOrder(const SampleMap& map, double C, double slope,
                   double slope_by_input, const VectorXd& start, int whole,
                   double past_input, const Eigen::Ref<const VectorXd>& inputs,
                   Eigen::Ref<MatrixXd> columns) {
  const Eigen::Index n = inputs.size();
  // u_{k−q} and u_{k−q−1}.
  const Eigen::Index late = std::min<Eigen::Index>(whole, n);
  VectorXd moved(n + 1);
  moved.head(late + 1).setConstant(past_input);
  moved.tail(n - late) = inputs.head(n - late);
  const auto older = moved.head(n);
  const auto newer = moved.tail(n);
  VectorXd x = map.older(0) * older + map.newer(0) * newer;
  Scan(1.0 + map.E(0, 0), start(0), x);
  columns.col(0) = C * x;
  if constexpr (kDerivatives) {
    VectorXd d = map.E(1, 0) * x + map.older(1) * older + map.newer(1) * newer;
    Scan(1.0 + map.E(1, 1), start(1), d);
    columns.col(1) = C * d;
    columns.col(2) = slope * x + slope_by_input * older;
  }
}

// Below this −E = 1 − a a loses digits that the state then lacks.
constexpr double kLeastDecay = 1e-4;

// RunFree() of first order.
Eigen::Index RunFreeFirstOrder(double A, double E, double C, double duration,
                               Eigen::Ref<MatrixXd> columns,
                               Eigen::Ref<MatrixXd> derivatives) {
  const double last = std::ceil(std::log(kForgottenResponse) / std::log1p(E));
  const auto kept = static_cast<Eigen::Index>(
      std::min(last, static_cast<double>(columns.rows())));
  VectorXd values = VectorXd::Zero(kept);
  Scan(1.0 + E, C, values);
  columns.setZero();
  derivatives.setZero();
  columns.col(0).head(kept) = values;
  for (Eigen::Index k = 0; k < kept; ++k) {
    derivatives(k, 0) = -static_cast<double>(k) * duration * A * values(k);
  }
  return kept;
}

template <int kOrder>
Eigen::Index RunFree(const MatrixXd& A, const MatrixXd& E,
                     const Eigen::RowVectorXd& C, double duration,
                     Eigen::Ref<MatrixXd> columns,
                     Eigen::Ref<MatrixXd> derivatives) {
  using Row = Eigen::Matrix<double, 1, kOrder>;
  Eigen::Matrix<double, kOrder, kOrder> rate;
  rate = A;
  Eigen::Matrix<double, kOrder, kOrder> change;
  change = E;
  const double forgotten = kForgottenResponse * C.norm();
  Row output = C;
  Row next = C;
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    if (output.cwiseAbs().maxCoeff() < forgotten) {
      const Eigen::Index rest = columns.rows() - k;
      columns.bottomRows(rest).setZero();
      derivatives.bottomRows(rest).setZero();
      return k;
    }
    columns.row(k) = output;
    next.noalias() = output * rate;
    derivatives.row(k) = -static_cast<double>(k) * duration * next;
    next.noalias() = output * change;
    output += next;
  }
  return columns.rows();
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
  const System system = SystemAt(time_scale);
  const auto r = static_cast<int>(system.A.rows());
  // States x and T ∂x/∂T, time in units of T.
  MatrixXd M = MatrixXd::Zero(2 * r, 2 * r);
  M.topLeftCorner(r, r) = system.A;
  M.bottomLeftCorner(r, r) = -system.A;
  M.bottomRightCorner(r, r) = system.A;
  VectorXd n(2 * r);
  n << system.B, -system.B;
  const int states = derivatives ? 2 * r : r;
  const SampleMap map =
      SampleMap::Over(sample_time / time_scale, delay.fraction,
                      M.topLeftCorner(states, states), n.head(states));
  VectorXd start = VectorXd::Zero(states);
  if (!integrating_) {
    start.head(r) = -A_.partialPivLu().solve(B_) * past_input;
  }
  if (!integrating_ && r == 1 && map.E(0, 0) < -kLeastDecay) {
    const auto run = derivatives ? RunFirstOrder<true> : RunFirstOrder<false>;
    run(map, C_(0), -C_(0) * A_(0, 0) / time_scale, -C_(0) * B_(0) / time_scale,
        start, delay.whole, past_input, inputs, columns);
    return;
  }
  const double base = integrating_ ? past_input : 0.0;
  WithOrder(r, [&](auto order) {
    constexpr int kOrder = decltype(order)::value;
    constexpr int kStates = kOrder == Eigen::Dynamic ? kOrder : 2 * kOrder;
    const auto run = derivatives ? RunOver<kStates, kOrder, true>
                                 : RunOver<kOrder, kOrder, false>;
    run(map, system.C, -system.C * system.A / time_scale,
        -system.C.dot(system.B) / time_scale, start, delay.whole, past_input,
        base, inputs, columns);
  });
  if (!integrating_ || !derivatives) return;
  // Of T z by ln T; without a lag that is nothing, to the last bit.
  columns.col(1) += columns.col(0);
  if (!has_time_scale()) columns.col(1).setZero();
}

Eigen::Index ElementResponse::FreeResponses(
    double time_scale, double sample_time, Eigen::Ref<MatrixXd> columns,
    Eigen::Ref<MatrixXd> derivatives) const {
  CHECK_EQ(columns.cols(), order());
  if (order() == 0) return 0;
  const double duration = sample_time / time_scale;
  const MatrixXd E = HeldInputMap::Over(duration, A_, B_).E;
  if (order() == 1 && E(0, 0) < -kLeastDecay && E(0, 0) > -1.0) {
    return RunFreeFirstOrder(A_(0, 0), E(0, 0), C_(0), duration, columns,
                             derivatives);
  }
  Eigen::Index kept = 0;
  WithOrder(order(), [&](auto order) {
    kept = RunFree<decltype(order)::value>(A_, E, C_, duration, columns,
                                           derivatives);
  });
  return kept;
}

}  // namespace mle
