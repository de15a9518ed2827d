// What a trial remembers (model_trial.h): a value that can be kept and resumed.

#ifndef MLE_TRIAL_TRIAL_STATE_H_
#define MLE_TRIAL_TRIAL_STATE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "mle/trial/trial_verdict.h"

namespace mle {

// The variogram of noise (change_window.h): sums over pairs of rows at rest, l
// apart.
struct Variogram {
  Eigen::VectorXd sums;    // l = 1, …: Σ (n_{k+l} − n_k)²/2
  Eigen::VectorXd counts;  // of pairs

  // G(l), 0 of l = 0.
  double at(Eigen::Index l) const;
};

// Squares of e_k − e_{k−h} of an output over each horizon, summed.
struct StepLosses {
  std::vector<double> in_use = {};
  std::vector<double> proposed = {};
  std::vector<double> counts = {};
};

// The root of the mean ratio of losses, proposed over in use, of all rows; 1
// without any. Feedback is part of it: no decision rests on it.
double LossRatio(const std::vector<StepLosses>& losses);

// All that a trial remembers; the models and options apart.
struct TrialState {
  static constexpr std::int64_t kLongAgo = -1'000'000'000;

  bool adopted = false;
  bool by_hand = false;  // inputs stand for set points
  // Of the end of the last row, in the unit of the records; and rows since the
  // last gap.
  double end = 0.0;
  std::int64_t rows = 0;
  std::int64_t last_move = kLongAgo;  // row
  std::int64_t response = kLongAgo;   // row that the present one began with
  int changes = 0;                    // of set points in it
  // The last rows (newest last): shapes (q × n), x, e⁰ and e¹ (r × n).
  Eigen::MatrixXd shapes;
  Eigen::MatrixXd differences;
  Eigen::MatrixXd in_use;
  Eigen::MatrixXd proposed;
  // The regression of x on shapes: q × q and q × r.
  Eigen::MatrixXd normal;
  Eigen::MatrixXd moments;
  // r each.
  std::vector<Variogram> noise;   // at rest
  std::vector<Variogram> always;  // of all rows
  std::vector<StepLosses> losses;
  // Those of the records before, of the trial, and since the adoption.
  std::vector<TrialResponse> learned;
  std::vector<TrialResponse> before;
  std::vector<TrialResponse> responses;
};

inline TrialVerdict JudgeTrial(const TrialState& state,
                               const TrialOptions& options) {
  return JudgeResponses(state.responses, state.learned, state.adopted, options);
}

// Sizes that fit a trial of so many outputs that change, rows of a response and
// horizons.
bool Fits(const TrialState& state, std::size_t outputs, Eigen::Index rows,
          std::size_t horizons);

}  // namespace mle

#endif  // MLE_TRIAL_TRIAL_STATE_H_
