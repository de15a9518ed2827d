// Moves of signals through discrete Laguerre functions, and the same moves at
// other times.
//
//   B_s   rows × (signals · functions): the moves of each signal later by the
//         share s of each record, those at the end first; each through the
//         functions L_1 … L_F with a pole e^{−Δt/T}; means over the rows of an
//         output.
//
// B_sᵀx needs no B_s: the functions run backward over x, once for all shares
// and signals, and sums of what comes out are taken where the signals move.
// N samples and m moves cost O(F (N + m · shares)) in place of N · F · signals
// · shares. Internal to mle/explain.

#ifndef MLE_EXPLAIN_MOVES_BANK_H_
#define MLE_EXPLAIN_MOVES_BANK_H_

#include <vector>

#include "Eigen/Core"
#include "mle/explain/explained_output.h"

namespace mle {

// A signal of each record, without gaps.
using RecordSignal = std::vector<Eigen::VectorXd>;
// The largest within a record.
double RangeOf(const RecordSignal& signal);

class MovesBank {
 public:
  // Functions of each signal.
  static constexpr int kFewestFunctions = 3;
  static constexpr int kMostFunctions = 6;

  MovesBank() = default;
  // Of signals that move; F is `functions`, within its bounds, and T `time`.
  MovesBank(const ExplainedOutput& output,
            const std::vector<RecordSignal>& signals, int functions,
            double time);

  Eigen::Index columns() const {
    return functions_ * static_cast<Eigen::Index>(signals_.size());
  }
  // B_s, or of its rows each `every`-th.
  Eigen::MatrixXd Columns(double share, int every = 1) const;
  // B_sᵀx, a column for each share (columns() × shares).
  Eigen::MatrixXd Project(const Eigen::VectorXd& x,
                          const std::vector<double>& shares) const;

 private:
  struct Move {
    int at = 0;  // sample
    double size = 0.0;
  };
  // The moves of each record, in units of the signal's range.
  using Moves = std::vector<std::vector<Move>>;

  int functions_ = 0;
  double pole_ = 0.0;
  std::vector<int> samples_;  // of each record
  std::vector<ResidualRow> rows_;
  std::vector<Moves> signals_;
};

}  // namespace mle

#endif  // MLE_EXPLAIN_MOVES_BANK_H_
