#include "mle/model/element_response.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "Eigen/Eigenvalues"
#include "Eigen/LU"
#include "glog/logging.h"
#include "mle/base/status.h"

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

// s_{k+1} = a s_k + g_k: s in place of g, and the last in `state`. Four samples
// at a time, so that a state does not wait for those between:
//
//   s_{k+4} = a⁴ s_k + a³ g_k + a² g_{k+1} + a g_{k+2} + g_{k+3}.
void Scan(double a, double& state, double* g, Eigen::Index count) {
  const double a2 = a * a;
  const double a3 = a2 * a;
  const double a4 = a2 * a2;
  double s = state;
  Eigen::Index k = 0;
  for (; k + 4 <= count; k += 4, g += 4) {
    const double g0 = g[0];
    const double g1 = a * g0 + g[1];
    const double g2 = a2 * g0 + (a * g[1] + g[2]);
    const double g3 = a2 * g1 + (a * g[2] + g[3]);
    g[0] = s;
    g[1] = a * s + g0;
    g[2] = a2 * s + g1;
    g[3] = a3 * s + g2;
    s = a4 * s + g3;
  }
  for (; k < count; ++k, ++g) {
    const double next = a * s + *g;
    *g = s;
    s = next;
  }
  state = s;
}

// RunFree() of first order.
void RunFreeFirstOrder(double A, double E, double C, double duration,
                       Eigen::Index samples, MatrixXd& columns,
                       MatrixXd& derivatives) {
  const double last = std::ceil(std::log(kForgottenResponse) / std::log1p(E));
  const auto kept =
      static_cast<Eigen::Index>(std::min(last, static_cast<double>(samples)));
  columns.setZero(kept, 1);
  derivatives.resize(kept, 1);
  double state = C;
  Scan(1.0 + E, state, columns.data(), kept);
  for (Eigen::Index k = 0; k < kept; ++k) {
    derivatives(k) = -static_cast<double>(k) * duration * A * columns(k);
  }
}

template <int kOrder>
void RunFree(const MatrixXd& A, const MatrixXd& E, const Eigen::RowVectorXd& C,
             double duration, Eigen::Index samples, MatrixXd& columns,
             MatrixXd& derivatives) {
  using Row = Eigen::Matrix<double, 1, kOrder>;
  Eigen::Matrix<double, kOrder, kOrder> rate;
  rate = A;
  Eigen::Matrix<double, kOrder, kOrder> change;
  change = E;
  const double forgotten = kForgottenResponse * C.norm();
  Row output = C;
  Row next = C;
  columns.resize(samples, C.size());
  derivatives.resize(samples, C.size());
  Eigen::Index kept = 0;
  while (kept < samples && !(output.cwiseAbs().maxCoeff() < forgotten)) {
    columns.row(kept) = output;
    next.noalias() = output * rate;
    derivatives.row(kept) = -static_cast<double>(kept) * duration * next;
    next.noalias() = output * change;
    output += next;
    ++kept;
  }
  columns.conservativeResize(kept, Eigen::NoChange);
  derivatives.conservativeResize(kept, Eigen::NoChange);
}

}  // namespace

ElementRun::FirstOrder ElementRun::AsFirstOrder() const {
  FirstOrder numbers = {.a = 1.0 + map_.E(0, 0),
                        .b1 = map_.older(0),
                        .b0 = map_.newer(0),
                        .C = C_(0),
                        .x = state_(0)};
  if (state_.size() > 1) {
    numbers.e = map_.E(1, 0);
    numbers.c1 = map_.older(1);
    numbers.c0 = map_.newer(1);
    numbers.s = slope_(0);
    numbers.t = slope_by_input_;
  }
  return numbers;
}

void ElementRun::TakeInputs(Eigen::Index n, double* inputs,
                            Eigen::Index stride) {
  const Eigen::Index begin = next_ - whole_ - 1;
  const Eigen::Index end = begin + n + 1;
  next_ += n;
  Eigen::Index k = begin;
  for (; k < std::min<Eigen::Index>(end, 0); ++k, inputs += stride) {
    *inputs = past_input_;
  }
  for (; k < end; ++k, inputs += stride) *inputs = inputs_[k];
}

template <bool kDerivatives>
void ElementRun::NextOfFirstOrder(Eigen::Ref<MatrixXd> columns) {
  constexpr int kPiece = 256;
  using Piece = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kPiece + 1, 1>;
  const FirstOrder by = AsFirstOrder();
  Piece inputs;
  Piece x;
  Piece d;
  for (Eigen::Index first = 0; first < columns.rows(); first += kPiece) {
    const Eigen::Index n =
        std::min<Eigen::Index>(kPiece, columns.rows() - first);
    inputs.resize(n + 1);
    TakeInputs(n, inputs.data(), 1);
    const auto older = inputs.head(n);
    const auto newer = inputs.tail(n);
    x = by.b1 * older + by.b0 * newer;
    Scan(by.a, state_(0), x.data(), n);
    columns.col(0).segment(first, n) = by.C * x;
    if constexpr (kDerivatives) {
      d = by.e * x + by.c1 * older + by.c0 * newer;
      Scan(by.a, state_(1), d.data(), n);
      columns.col(1).segment(first, n) = by.C * d;
      columns.col(2).segment(first, n) = by.s * x + by.t * older;
    }
  }
}

template <int kStates, int kOrder, bool kDerivatives>
void ElementRun::NextOfAnyOrder(Eigen::Ref<MatrixXd> columns) {
  using State = Eigen::Matrix<double, kStates, 1>;
  using Row = Eigen::Matrix<double, 1, kOrder>;
  const auto r = static_cast<int>(C_.size());
  const Eigen::Matrix<double, kStates, kStates> E = map_.E;
  const State by_older = map_.older;
  const State by_newer = map_.newer;
  Row output;
  output = C_;
  Row slope_by_state;
  slope_by_state = slope_;
  State state = state_;
  State move = state_;
  double older = InputAt(-1) - base_;
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    const auto x = state.head(Eigen::fix<kOrder>(r));
    columns(k, 0) = output.dot(x);
    if constexpr (kDerivatives) {
      columns(k, 1) = output.dot(state.tail(Eigen::fix<kOrder>(r)));
      columns(k, 2) = slope_by_state.dot(x) + slope_by_input_ * older;
    }
    const double newer = InputAt(k) - base_;
    // setZero(), of which g++ 12 warns where the library is one source.
    std::fill_n(move.data(), move.size(), 0.0);
    move.noalias() += E * state;
    move += by_older * older + by_newer * newer;
    state += move;
    older = newer;
  }
  state_ = state;
  next_ += columns.rows();
}

void ElementRun::Next(Eigen::Ref<MatrixXd> columns) {
  const bool derivatives = columns.cols() > 1;
  CHECK_EQ(state_.size(), (derivatives ? 2 : 1) * C_.size());
  if (is_first_order()) {
    if (derivatives) {
      NextOfFirstOrder<true>(columns);
    } else {
      NextOfFirstOrder<false>(columns);
    }
    return;
  }
  WithOrder(C_.size(), [&](auto order) {
    constexpr int kOrder = decltype(order)::value;
    constexpr int kStates = kOrder == Eigen::Dynamic ? kOrder : 2 * kOrder;
    if (derivatives) {
      NextOfAnyOrder<kStates, kOrder, true>(columns);
    } else {
      NextOfAnyOrder<kOrder, kOrder, false>(columns);
    }
  });
  if (!integrating_ || !derivatives) return;
  // The response of an integrating element is T z, so that its derivative by ln
  // T has T z besides; without a lag the derivative is zero, to the last bit.
  columns.col(1) += columns.col(0);
  if (!has_time_scale_) columns.col(1).setZero();
}

ElementRun ElementResponse::Run(double time_scale, double sample_time,
                                SampledDelay delay,
                                const Eigen::Ref<const VectorXd>& inputs,
                                double past_input, bool derivatives) const {
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
  ElementRun run(
      SampleMap::Over(sample_time / time_scale, delay.fraction,
                      M.topLeftCorner(states, states), n.head(states)),
      system.C, -system.C * system.A / time_scale,
      -system.C.dot(system.B) / time_scale);
  run.state_.setZero(states);
  if (!integrating_) {
    run.state_.head(r) = -A_.partialPivLu().solve(B_) * past_input;
  }
  run.inputs_ = inputs.data();
  run.past_input_ = past_input;
  run.base_ = integrating_ ? past_input : 0.0;
  run.whole_ = delay.whole;
  run.integrating_ = integrating_;
  run.has_time_scale_ = has_time_scale();
  return run;
}

void ElementResponse::Simulate(double time_scale, double sample_time,
                               SampledDelay delay,
                               const Eigen::Ref<const VectorXd>& inputs,
                               double past_input,
                               Eigen::Ref<MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), inputs.size());
  const bool derivatives = columns.cols() > 1;
  CHECK_EQ(columns.cols(), derivatives ? 3 : 1);
  Run(time_scale, sample_time, delay, inputs, past_input, derivatives)
      .Next(columns);
}

void ElementResponse::FreeResponses(double time_scale, double sample_time,
                                    Eigen::Index samples, MatrixXd& columns,
                                    MatrixXd& derivatives) const {
  columns.resize(0, order());
  derivatives.resize(0, order());
  if (order() == 0) return;
  const double duration = sample_time / time_scale;
  const MatrixXd E = HeldInputMap::Over(duration, A_, B_).E;
  if (order() == 1 && E(0, 0) < -ElementRun::kLeastDecay && E(0, 0) > -1.0) {
    RunFreeFirstOrder(A_(0, 0), E(0, 0), C_(0), duration, samples, columns,
                      derivatives);
    return;
  }
  WithOrder(order(), [&](auto order) {
    RunFree<decltype(order)::value>(A_, E, C_, duration, samples, columns,
                                    derivatives);
  });
}

}  // namespace mle
