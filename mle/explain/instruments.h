// The part of a residual that set points drive, and the part that placebos
// drive: set points that were moved in time.
//
//   Q    orthonormal basis (rows × r) of the moves of the instruments, the
//        earlier half of each apart from the later, so that what changed
//        between them shows; each through three to six discrete Laguerre
//        functions (moves_bank.h; eight rows for each column) with a time
//        constant of 0.6 τ, freed of an offset and a ramp for each record (a
//        sensor that drifts, a level that is not balanced) and of what earlier
//        inputs leave, e^{−t/T};
//   Q_s  the same with the moves shifted in time by s of the record, joined at
//        the ends, s = 1/41 … 40/41;
//   v = Qᵀe,   v_s = Q_sᵀ e.
//
// Disturbances that do not come with set points give v and v_s the same
// distribution, whatever the controller makes of them: v_s are what chance
// makes of v, with no model of the noise. (Instrumental variables in closed
// loop: Söderström and Stoica, Instrumental Variable Methods for System
// Identification, 1983; Gilson and Van den Hof, Automatica 41, 2005.
// Randomisation tests: Fisher, The Design of Experiments, 1935.) What this
// cannot see: a disturbance that comes with the moves of set points.
//
// Instruments are the set points that move, and measured disturbances; where
// no set point moves, the inputs themselves, which then have to move by
// something else than the output: nothing guards against feedback.
// Internal to mle/explain.

#ifndef MLE_EXPLAIN_INSTRUMENTS_H_
#define MLE_EXPLAIN_INSTRUMENTS_H_

#include <functional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/explain/explained_output.h"
#include "mle/explain/moves_bank.h"

namespace mle {

class Instruments {
 public:
  // FailedPrecondition where nothing moves.
  static absl::StatusOr<Instruments> Create(const ProcessModel& model,
                                            const ExplainedOutput& output);

  // How many instruments each of them was made: 1, or up to 2.
  double parts() const { return parts_; }
  // r, of Q.
  int rank() const { return static_cast<int>(to_basis_.cols()); }
  // Set points move; if not, inputs stand for them.
  bool by_set_points() const { return by_set_points_; }
  // Moves of the instruments, all together.
  int moves() const { return moves_; }

  // What the instruments do not drive of e.
  Eigen::VectorXd Undriven(const Eigen::VectorXd& e) const;
  // Qᵀe.
  Eigen::VectorXd Project(const Eigen::VectorXd& e) const;
  // The same of the rows of weight one alone, freed of what offsets and free
  // responses explain of these; rows of weight zero have no part in it. Refers
  // to these instruments.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& e)> ProjectionOf(
      const Eigen::VectorXd& weights) const;
  // Q_sᵀe, a row for each placebo (placebos × r).
  Eigen::MatrixXd ProjectPlacebos(const Eigen::VectorXd& e) const;
  // e without the offsets and free responses nearest to it.
  Eigen::VectorXd Freed(const Eigen::VectorXd& e) const {
    return e - free_ * (free_.transpose() * e);
  }

 private:
  Instruments() = default;

  // FailedPrecondition where nothing is left of the moves.
  absl::Status FindBasis();
  void FindPlacebos(const ExplainedOutput& output);

  bool by_set_points_ = false;
  int moves_ = 0;
  double parts_ = 1.0;
  Eigen::MatrixXd free_;  // rows × f, orthonormal
  MovesBank bank_;
  Eigen::MatrixXd to_basis_;  // Q = freed B_0 times this
  std::vector<double> shares_;
  std::vector<Eigen::MatrixXd> to_placebo_;  // Q_s, of each share
};

}  // namespace mle

#endif  // MLE_EXPLAIN_INSTRUMENTS_H_
