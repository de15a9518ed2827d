// The outputs that are to come while no input moves, f_{l+k} for k = 0 … n,
// carried from instant to instant (dynamic matrix control: Cutler and Ramaker,
// Joint Automatic Control Conference, 1980).
//
// Only pairs that exist are carried, and each as far as its step response is on
// its way: f = level + deviation, where a move v of input j adds S_n v to the
// level of output i and (S_k − S_n) v to its deviation, until that is below
// 1e-12 of the response. A response that ends in a ramp is all deviation. A
// move takes as many operations as there are such values in column j.

#ifndef CONTROL_FREE_RESPONSE_H_
#define CONTROL_FREE_RESPONSE_H_

#include <vector>

#include "Eigen/Core"
#include "control/prediction_model.h"

namespace mle::control {

class FreeResponse {
 public:
  // All inputs have been zero for ever.
  explicit FreeResponse(const PredictionModel& model);

  // Input j is larger by `move` from the coming instant l on.
  void Move(int input, double move);
  // To the next instant. Beyond the last one outputs stay, or go on with their
  // ramps.
  void Advance();
  // All inputs have been `inputs` (m) for so long that nothing moves but ramps,
  // which begin at the coming instant: what was integrated before is not known.
  void Settle(const Eigen::Ref<const Eigen::VectorXd>& inputs);

  // f_{l+k} of all outputs (p), 0 ≤ k ≤ n.
  auto At(Eigen::Index k) const {
    return levels_ + deviations_.col(first_ + k);
  }
  // f_{l+k+1} − f_{l+k} beyond n (p).
  const Eigen::VectorXd& ramp() const { return ramp_; }

 private:
  struct Pair {
    int output = 0;
    double level = 0.0;
    double slope = 0.0;         // of its ramp
    Eigen::VectorXd deviation;  // from k = 0 on
  };

  std::vector<std::vector<Pair>> pairs_;  // of each input
  Eigen::Index count_;                    // n + 1
  Eigen::VectorXd levels_;                // p
  Eigen::VectorXd ramp_;                  // p
  // p × 2(n+1), by output: the columns from first_ on are f_l, …, f_{l+n}.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
      deviations_;
  Eigen::Index first_ = 0;
};

}  // namespace mle::control

#endif  // CONTROL_FREE_RESPONSE_H_
