#include "mle/nonlinear/response_rows.h"

#include <algorithm>
#include <utility>

#include "mle/regression/kernels/kernels.h"

namespace mle {
namespace {

using Eigen::Index;
using Numbers = FirstOrderElements;

constexpr Index kLanes = 8;

}  // namespace

ResponseRows::ResponseRows(const OutputErrorProblem& problem,
                           std::vector<int> elements)
    : problem_(problem),
      elements_(std::move(elements)),
      gains_(elements_.size()),
      order_(elements_.size()),
      places_(3 * elements_.size()) {}

void ResponseRows::Start(const OutputErrorProblem::Segment& segment,
                         const OutputPoint& point, bool derivatives) {
  derivatives_ = derivatives;
  next_ = 0;
  runs_.clear();
  num_side_by_side_ = 0;
  for (std::size_t f = 0; f < elements_.size(); ++f) {
    gains_[f] = point.values[elements_[f]].gain;
    runs_.push_back(problem_.Run(segment, point, elements_[f], derivatives));
    if (runs_[f].is_first_order()) order_[f] = num_side_by_side_++;
  }
  Index other = num_side_by_side_;
  for (std::size_t f = 0; f < elements_.size(); ++f) {
    if (!runs_[f].is_first_order()) order_[f] = other++;
    for (Index i = 0; i < 3; ++i) places_[3 * f + i] = i * count() + order_[f];
  }
  // The states: −C x, y with the sign of the residuals, and −K C d.
  const Index width = (num_side_by_side_ + kLanes - 1) / kLanes * kLanes;
  numbers_.setZero(Numbers::kNumbers, width);
  state_.setZero(2 * width);
  inputs_.setZero(0, width);
  for (std::size_t f = 0; f < elements_.size(); ++f) {
    if (!runs_[f].is_first_order()) continue;
    const ElementRun::FirstOrder of = runs_[f].AsFirstOrder();
    const double K = gains_[f];
    numbers_.col(order_[f]) << of.a, -of.C * of.b1, -of.C * of.b0, K * of.e,
        -K * of.C * of.c1, -K * of.C * of.c0, K * of.s / of.C, -K * of.t, K;
    state_(order_[f]) = -of.C * of.x;
  }
}

void ResponseRows::Next(const int* times, Index count, double* rest,
                        double* rows, Index stride) {
  const int begin = next_;
  const Index samples = times[count - 1] + 1 - begin;
  next_ = times[count - 1] + 1;
  if (samples == count) {
    Run(samples, rest, rows, stride);
    return;
  }
  scratch_.resize(samples, 3 * this->count());
  scratch_rest_.setZero(samples);
  Run(samples, scratch_rest_.data(), scratch_.data(), scratch_.cols());
  for (Index row = 0; row < count; ++row) {
    const Index k = times[row] - begin;
    rest[row] += scratch_rest_(k);
    if (!derivatives_) continue;
    std::copy_n(&scratch_(k, 0), scratch_.cols(), rows + row * stride);
  }
}

void ResponseRows::Run(Index samples, double* rest, double* rows,
                       Index stride) {
  const Index width = numbers_.cols();
  if (width > 0) {
    if (inputs_.rows() <= samples) inputs_.setZero(samples + 1, width);
    for (std::size_t f = 0; f < elements_.size(); ++f) {
      if (!runs_[f].is_first_order()) continue;
      runs_[f].TakeInputs(samples, inputs_.data() + order_[f], width);
    }
    VectorKernels().run_first_order({.numbers = numbers_.data(),
                                     .width = width,
                                     .count = num_side_by_side_},
                                    samples, inputs_.data(), state_.data(),
                                    rest, derivatives_ ? rows : nullptr, stride,
                                    count());
  }
  if (num_side_by_side_ == count()) return;
  piece_.resize(samples, derivatives_ ? 3 : 1);
  for (std::size_t f = 0; f < elements_.size(); ++f) {
    if (runs_[f].is_first_order()) continue;
    runs_[f].Next(piece_);
    for (Index k = 0; k < samples; ++k) rest[k] -= gains_[f] * piece_(k, 0);
    if (!derivatives_) continue;
    double* to = rows + order_[f];
    for (Index k = 0; k < samples; ++k, to += stride) {
      to[0] = -piece_(k, 0);
      to[count()] = -gains_[f] * piece_(k, 1);
      to[2 * count()] = -gains_[f] * piece_(k, 2);
    }
  }
}

}  // namespace mle
