#include "control/free_response.h"

#include <cmath>
#include <utility>

#include "glog/logging.h"

namespace mle::control {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of the largest value of a step response.
constexpr double kNoDeviation = 1e-12;

}  // namespace

FreeResponse::FreeResponse(const PredictionModel& model)
    : pairs_(model.num_outputs),
      num_inputs_(model.num_inputs()),
      count_(model.periods() + 1),
      levels_(VectorXd::Zero(model.num_outputs)),
      ramp_(VectorXd::Zero(model.num_outputs)) {
  const Index p = model.num_outputs;
  deviations_.setZero(p, 2 * count_);
  std::vector<double> deviations;
  for (Index i = 0; i < p; ++i) {
    for (int j = 0; j < num_inputs_; ++j) {
      Pair pair = {.input = j, .length = count_};
      VectorXd deviation =
          model.responses.col(j)(Eigen::seqN(i, count_, p)).eval();
      const double largest = deviation.cwiseAbs().maxCoeff();
      if (model.slopes.size() > 0) pair.slope = model.slopes(i, j);
      if (largest == 0.0 && pair.slope == 0.0) continue;
      if (pair.slope == 0.0) {
        pair.level = deviation(count_ - 1);
        deviation.array() -= pair.level;
        while (pair.length > 0 &&
               std::abs(deviation(pair.length - 1)) <= kNoDeviation * largest) {
          --pair.length;
        }
      }
      deviations.insert(deviations.end(), deviation.begin(),
                        deviation.begin() + pair.length);
      pairs_[i].push_back(pair);
    }
  }
  deviations_of_pairs_ = Eigen::Map<const VectorXd>(
      deviations.data(), static_cast<Index>(deviations.size()));
}

void FreeResponse::Move(const Eigen::Ref<const VectorXd>& moves) {
  CHECK_EQ(moves.size(), num_inputs_);
  Index at = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto output = static_cast<Index>(i);
    for (const Pair& pair : pairs_[i]) {
      const double move = moves(pair.input);
      if (move != 0.0) {
        levels_(output) += pair.level * move;
        ramp_(output) += pair.slope * move;
        deviations_.row(output).segment(first_, pair.length).noalias() +=
            move * deviations_of_pairs_.segment(at, pair.length).transpose();
      }
      at += pair.length;
    }
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
  CHECK_EQ(inputs.size(), num_inputs_);
  levels_.setZero();
  ramp_.setZero();
  first_ = 0;
  Index at = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto output = static_cast<Index>(i);
    for (const Pair& pair : pairs_[i]) {
      at += pair.length;
      const double last =
          pair.slope == 0.0 ? pair.level : deviations_of_pairs_(at - 1);
      levels_(output) += last * inputs(pair.input);
      ramp_(output) += pair.slope * inputs(pair.input);
    }
  }
  for (Index k = 0; k < count_; ++k) {
    deviations_.col(k) = static_cast<double>(k) * ramp_;
  }
}

}  // namespace mle::control
