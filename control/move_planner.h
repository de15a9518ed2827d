// The optimisation inside a predictive controller: from predicted errors to
// planned moves.
//
//   min_{Δu} Σ_{i=1}^{H_p} ‖e_i − Σ_{b: t_b ≤ i} S_{i−t_b} Δu_b‖²_{Q_y}
//            + Σ_b ‖Δu_b‖²_{Q_u},
//
// where e_i is the error at instant l+i without moves and Δu_b (m_c) the b-th
// move, acting from l + t_b on. Without limits the first move is a matrix times
// the errors; with limits a QuadraticProgram in all moves is solved, where that
// answer breaks a limit. Setting up takes O(H_c p m_c² H_p) operations without
// limits and the same once more for each move with them.
//
// Beyond the horizon an integrating output goes on with the slope that it has
// at its end, s = ŷ_{l+H_p} − ŷ_{l+H_p−1}: the inputs have to balance it. What
// this slope makes of the error over another horizon is added for the outputs
// that integrate,
//
//   Σ_{i=1}^{H_p} ‖i s‖²_{Q_y} = H_p (H_p + 1)(2 H_p + 1)/6 ‖s‖²_{Q_y}.

#ifndef CONTROL_MOVE_PLANNER_H_
#define CONTROL_MOVE_PLANNER_H_

#include <optional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "control/mpc_options.h"
#include "control/prediction_model.h"
#include "control/quadratic_program.h"

namespace mle::control {

// How one control instant went.
struct PlanSummary {
  // Rows of the programme at their limits; 0 where the closed form holds.
  int active_limits = 0;
  int iterations = 0;
  // The plan is optimal. Else, after a numerical failure, it is the
  // unconstrained one cut to the limits.
  bool optimal = true;
  // An input stood so far outside its limits that its move limit lets it come
  // back only step by step: its limits were widened on the way to what can be
  // reached.
  bool limits_widened = false;
  // Largest predicted violation of an output's soft limit.
  double output_violation = 0.0;
};

class MovePlanner {
 public:
  // For m_c ≥ 1 manipulated inputs. `model`, which reaches to H_p, and
  // `options` are valid for each other. InvalidArgument if the weights do not
  // determine the moves.
  static absl::StatusOr<MovePlanner> Create(const PredictionModel& model,
                                            const MpcOptions& options);

  // m_c × p H_p: the first unconstrained move is its product with the stacked
  // errors e_1; …; e_{H_p}.
  const Eigen::MatrixXd& gain() const { return gain_; }
  bool has_limits() const { return program_.has_value(); }

  // Plans all moves. `errors` and `free_outputs` (p H_p) are the errors and the
  // outputs predicted without moves, `inputs` (m_c) what was sent last.
  // Allocates nothing.
  const PlanSummary& Plan(const Eigen::Ref<const Eigen::VectorXd>& errors,
                          const Eigen::Ref<const Eigen::VectorXd>& free_outputs,
                          const Eigen::Ref<const Eigen::VectorXd>& inputs);

  // m_c × number of blocks: the inputs after each planned move. Without limits
  // only the first is computed.
  const Eigen::MatrixXd& planned_inputs() const { return planned_; }

 private:
  MovePlanner() = default;

  // Which quantity a row of the programme limits.
  struct Row {
    enum class Kind { kInput, kMove, kOutput } kind;
    int channel = 0;  // input (of the m_c) or output
    int step = 0;     // block b or instant i − 1
  };

  // Whether there is any.
  bool SetLimits(const std::vector<int>& manipulated, const MpcLimits& limits);
  absl::Status AddLimits(const Eigen::MatrixXd& dynamic,
                         const Eigen::MatrixXd& hessian);
  void SetBounds(const Eigen::Ref<const Eigen::VectorXd>& free_outputs,
                 const Eigen::Ref<const Eigen::VectorXd>& inputs);
  void CutToLimits(const Eigen::Ref<const Eigen::VectorXd>& moves,
                   const Eigen::Ref<const Eigen::VectorXd>& inputs);
  double OutputViolation() const;

  int num_inputs_ = 0;   // m_c
  int num_outputs_ = 0;  // p
  int num_blocks_ = 0;
  Eigen::MatrixXd gain_;
  Eigen::MatrixXd full_gain_;  // all moves; only with limits

  std::optional<QuadraticProgram> program_;
  std::vector<Row> rows_;
  Eigen::VectorXd min_input_, max_input_, max_move_;  // m_c
  Eigen::VectorXd min_output_, max_output_;           // p
  Eigen::VectorXd output_limit_cost_;                 // p
  Eigen::MatrixXd lowest_, highest_;  // m_c × blocks: widened limits
  Eigen::VectorXd lower_, upper_;     // of the rows

  Eigen::VectorXd moves_;    // m_c × blocks, stacked
  Eigen::MatrixXd planned_;  // m_c × blocks
  PlanSummary summary_;
};

}  // namespace mle::control

#endif  // CONTROL_MOVE_PLANNER_H_
