#include "control/free_response.h"

#include <cmath>
#include <utility>

#include "glog/logging.h"

namespace mle::control {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// A deviation below this share of the largest value of a step response is none.
constexpr double kNoDeviation = 1e-12;

}  // namespace

FreeResponse::FreeResponse(const PredictionModel& model)
    : pairs_(model.num_inputs()),
      count_(model.periods() + 1),
      levels_(VectorXd::Zero(model.num_outputs)),
      ramp_(VectorXd::Zero(model.num_outputs)) {
  const Index p = model.num_outputs;
  deviations_.setZero(p, 2 * count_);
  for (int j = 0; j < model.num_inputs(); ++j) {
    for (Index i = 0; i < p; ++i) {
      Pair pair = {.output = static_cast<int>(i)};
      pair.deviation = model.responses.col(j)(Eigen::seqN(i, count_, p)).eval();
      const double largest = pair.deviation.cwiseAbs().maxCoeff();
      if (model.slopes.size() > 0) pair.slope = model.slopes(i, j);
      if (largest == 0.0 && pair.slope == 0.0) continue;
      if (pair.slope == 0.0) {
        pair.level = pair.deviation(count_ - 1);
        pair.deviation.array() -= pair.level;
        Index left = count_;
        while (left > 0 &&
               std::abs(pair.deviation(left - 1)) <= kNoDeviation * largest) {
          --left;
        }
        pair.deviation.conservativeResize(left);
      }
      pairs_[j].push_back(std::move(pair));
    }
  }
}

void FreeResponse::Move(int input, double move) {
  if (move == 0.0) return;
  for (const Pair& pair : pairs_[input]) {
    levels_(pair.output) += pair.level * move;
    ramp_(pair.output) += pair.slope * move;
    deviations_.row(pair.output)
        .segment(first_, pair.deviation.size())
        .noalias() += move * pair.deviation.transpose();
  }
}

void FreeResponse::Advance() {
  ++first_;
  if (first_ == count_) {
    deviations_.leftCols(count_ - 1) =
        deviations_.middleCols(first_, count_ - 1);
    first_ = 0;
  }
  const Index last = first_ + count_ - 1;
  deviations_.col(last) = deviations_.col(last - 1) + ramp_;
}

void FreeResponse::Settle(const Eigen::Ref<const VectorXd>& inputs) {
  CHECK_EQ(inputs.size(), static_cast<Index>(pairs_.size()));
  levels_.setZero();
  ramp_.setZero();
  first_ = 0;
  for (std::size_t j = 0; j < pairs_.size(); ++j) {
    for (const Pair& pair : pairs_[j]) {
      const double last =
          pair.slope == 0.0 ? pair.level : pair.deviation(count_ - 1);
      levels_(pair.output) += last * inputs(static_cast<Index>(j));
      ramp_(pair.output) += pair.slope * inputs(static_cast<Index>(j));
    }
  }
  for (Index k = 0; k < count_; ++k) {
    deviations_.col(k) = static_cast<double>(k) * ramp_;
  }
}

}  // namespace mle::control
