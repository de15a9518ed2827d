#include "control/expected_operation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mle/base/status.h"
#include "mle/model/process_simulator.h"

namespace mle::control {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSettlingTimes = 2.0;  // at first
constexpr int kLeastInstants = 50;
constexpr int kMostInstants = 50'000;
// A response has settled if no error in its last quarter is above this share of
// the largest value of that error.
constexpr double kSettled = 1e-3;
// An error below this share of a unit step is rounding; one above kRunaway runs
// away.
constexpr double kNothing = 1e-9;
constexpr double kRunaway = 1e6;

// E max(0, d + σ z).
double MeanAbove(double distance, double deviation) {
  if (!(deviation > 0.0)) return std::max(distance, 0.0);
  const double scaled = distance / (deviation * std::numbers::sqrt2);
  return 0.5 * (distance * std::erfc(-scaled) +
                deviation * std::numbers::sqrt2 * std::numbers::inv_sqrtpi *
                    std::exp(-scaled * scaled));
}

// E max(0, |m + σ z| − w).
double MeanBeyond(double allowed, double mean, double deviation) {
  if (std::isinf(allowed)) return 0.0;
  return MeanAbove(mean - allowed, deviation) +
         MeanAbove(-mean - allowed, deviation);
}

// The loop's answer: a row for each error, then for each input's move.
struct LoopResponse {
  MatrixXd rows;  // (p + m) × N
  bool settled = false;
};

class SimulatedLoop {
 public:
  SimulatedLoop(const Mpc& mpc, const ProcessModel& plant)
      : mpc_(mpc),
        plant_(plant),
        p_(plant.num_outputs()),
        m_(plant.num_inputs()),
        instants_(std::max(
            static_cast<int>(std::ceil(kSettlingTimes * SettlingTime(plant) /
                                       mpc.options().control_period)),
            kLeastInstants)) {}

  // To unit steps from instant 0 on: of the disturbances, then of the set
  // points of the outputs; all of one length.
  absl::StatusOr<std::vector<LoopResponse>> StepResponses();

 private:
  absl::StatusOr<LoopResponse> Respond(int output, bool set_point) const;

  const Mpc& mpc_;
  const ProcessModel& plant_;
  int p_;
  int m_;
  int instants_;
};

absl::StatusOr<LoopResponse> SimulatedLoop::Respond(int output,
                                                    bool set_point) const {
  Mpc mpc = mpc_;
  mpc.Restart(VectorXd::Zero(m_), VectorXd::Zero(p_));
  MLE_ASSIGN_OR_RETURN(
      ProcessSimulator plant,
      ProcessSimulator::Create(plant_, mpc.options().control_period));
  const VectorXd step = VectorXd::Unit(p_, output);
  const VectorXd disturbance = set_point ? VectorXd::Zero(p_).eval() : step;
  const VectorXd set_points = set_point ? step : VectorXd::Zero(p_).eval();
  LoopResponse response{.rows = MatrixXd::Zero(p_ + m_, instants_)};
  VectorXd inputs = VectorXd::Zero(m_);
  VectorXd next = inputs;
  for (int k = 0; k < instants_; ++k) {
    const VectorXd outputs = plant.outputs() + disturbance;
    mpc.Step(outputs, set_points, next);
    response.rows.col(k) << outputs - set_points, next - inputs;
    if (!(response.rows.col(k).head(p_).cwiseAbs().maxCoeff() < kRunaway)) {
      return response;
    }
    plant.Advance(inputs);
    inputs = next;
  }
  const MatrixXd errors = response.rows.topRows(p_).cwiseAbs();
  const VectorXd largest = errors.rowwise().maxCoeff();
  const VectorXd last = errors.rightCols(instants_ / 4).rowwise().maxCoeff();
  response.settled =
      (last.array() <= kSettled * largest.array() + kNothing).all();
  return response;
}

absl::StatusOr<std::vector<LoopResponse>> SimulatedLoop::StepResponses() {
  for (; instants_ <= kMostInstants; instants_ *= 2) {
    std::vector<LoopResponse> responses;
    for (const bool set_point : {false, true}) {
      for (int i = 0; i < p_; ++i) {
        MLE_ASSIGN_OR_RETURN(LoopResponse response, Respond(i, set_point));
        responses.push_back(std::move(response));
        if (!responses.back().settled) break;
      }
      if (!responses.back().settled) break;
    }
    if (responses.back().settled) return responses;
    // A response that has grown so far does not come back.
    if (!(responses.back().rows.cwiseAbs().maxCoeff() < kRunaway)) break;
  }
  return absl::FailedPreconditionError(
      "the loop does not settle: it is not stable, or has outputs that the "
      "inputs cannot hold");
}

// Σ_h γ(|h|) Σ_k x(k) x(k + |h|) for each row x.
VectorXd VarianceFrom(const std::vector<double>& covariances,
                      const MatrixXd& impulse) {
  VectorXd variance = VectorXd::Zero(impulse.rows());
  const auto lags =
      std::min(static_cast<Index>(covariances.size()), impulse.cols());
  for (Index h = 0; h < lags; ++h) {
    const Index count = impulse.cols() - h;
    const double weight =
        (h == 0 ? 1.0 : 2.0) * covariances[static_cast<std::size_t>(h)];
    variance += weight *
                (impulse.leftCols(count).cwiseProduct(impulse.rightCols(count)))
                    .rowwise()
                    .sum();
  }
  return variance;
}

// Σ_k x(k)² for each row x behind a lag, x(k) ← φ x(k−1) + (1 − φ) step(k−1),
// what is left after the end with it.
VectorXd SquaresBehindLag(const MatrixXd& step, double lag) {
  const double pole = std::exp(-1.0 / lag);
  VectorXd lagged = VectorXd::Zero(step.rows());
  VectorXd squares = lagged;
  for (const auto& column : step.colwise()) {
    lagged = pole * lagged + (1.0 - pole) * column;
    squares += lagged.cwiseAbs2();
  }
  return squares + pole * pole / (1.0 - pole * pole) * lagged.cwiseAbs2();
}

// p + m: σ² of what answers this output's noise and disturbances.
VectorXd VarianceOf(const OutputConditions& conditions, const MatrixXd& step,
                    int output) {
  MatrixXd impulse = step;
  impulse.rightCols(step.cols() - 1) -= step.leftCols(step.cols() - 1);
  VectorXd variance = conditions.walk_variance *
                          (conditions.walk_lag > 0.0
                               ? SquaresBehindLag(step, conditions.walk_lag)
                               : VectorXd(step.rowwise().squaredNorm())) +
                      VarianceFrom(conditions.covariances, impulse);
  impulse(output, 0) -= 1.0;
  variance += conditions.noise_variance * impulse.rowwise().squaredNorm();
  return variance.cwiseMax(0.0);
}

}  // namespace

absl::StatusOr<ExpectedOperation> ExpectOperation(
    const Mpc& mpc, const ProcessModel& plant,
    const std::vector<OutputConditions>& conditions) {
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  if (mpc.model().num_outputs != p || mpc.model().num_inputs() != m ||
      conditions.size() != static_cast<std::size_t>(p)) {
    return InvalidArgument(
        "expected operation: the plant has ", p, " outputs and ", m,
        " inputs, the controller ", mpc.model().num_outputs, " and ",
        mpc.model().num_inputs(), ", and there are conditions for ",
        conditions.size(), " outputs; they must agree");
  }
  SimulatedLoop loop(mpc, plant);
  MLE_ASSIGN_OR_RETURN(const std::vector<LoopResponse> responses,
                       loop.StepResponses());
  VectorXd variance = VectorXd::Zero(p + m);
  for (int i = 0; i < p; ++i) {
    variance += VarianceOf(conditions[i], responses[i].rows, i);
  }
  const VectorXd deviation = variance.cwiseSqrt();
  const double period = mpc.options().control_period;
  ExpectedOperation operation{.sums = OperationSums::Zero(p, m),
                              .resting_variance = variance.head(p)};
  OperationSums& sums = operation.sums;
  sums.time = 1.0;
  sums.squared_error = operation.resting_variance;
  for (int i = 0; i < p; ++i) {
    sums.absolute_error(i) = MeanBeyond(0.0, 0.0, deviation(i));
    sums.violation(i) =
        MeanBeyond(conditions[i].allowed_error, 0.0, deviation(i));
  }
  for (int j = 0; j < m; ++j) {
    sums.movement(j) = MeanBeyond(0.0, 0.0, deviation(p + j)) / period;
  }
  for (int i = 0; i < p; ++i) {
    const OutputConditions& met = conditions[i];
    if (!(met.changes > 0.0)) continue;
    const MatrixXd moved = met.change_size * responses[p + i].rows;
    sums.squared_error +=
        met.changes * period * moved.topRows(p).rowwise().squaredNorm();
    // Σ_k [A_w(s R(k), σ) − A_w(0, σ)].
    const auto more = [&](Index row, double allowed) {
      double sum = 0.0;
      for (const double mean : moved.row(row)) {
        sum += MeanBeyond(allowed, mean, deviation(row)) -
               MeanBeyond(allowed, 0.0, deviation(row));
      }
      return sum;
    };
    for (int row = 0; row < p; ++row) {
      sums.absolute_error(row) += met.changes * period * more(row, 0.0);
      sums.violation(row) +=
          met.changes * period * more(row, conditions[row].allowed_error);
    }
    for (int j = 0; j < m; ++j) {
      sums.movement(j) += met.changes * more(p + j, 0.0);
    }
  }
  return operation;
}

}  // namespace mle::control
