// Model predictive control (the paper's Eq. 4–5), with limits.
//
// At control instant l the moves Δu_1 … Δu_{H_c} minimise
//
//   J = Σ_{i=1}^{H_p} ‖r_l − ŷ_{l+i}‖²_{Q_y} + Σ_{i=1}^{H_c} ‖Δu_i‖²_{Q_u},
//   ŷ_{l+i} = f_{l+i} + ŵ_l + i d̂_l + Σ_{j=1}^{min(i, H_c)} S_{i−j} Δu_j,
//
// within the limits of MpcOptions, where S_i is the model's step response at
// iΔt_c (S_0 = 0: move j acts from instant l+j on), f its free response to the
// inputs sent so far and to the measured disturbances, ŵ the observed
// disturbance and d̂ its slope, of integrating outputs alone. The set point is
// assumed constant, unless its future is given. u_l + Δu_1 acts from instant
// l+1. Without limits the minimiser is linear in the predicted error, so one
// instant costs one product with a gain made beforehand (move_planner.h).
//
// An integrating output is at rest where its inputs balance it: J has the slope
// that a plan ends with besides (move_planner.h), and a constant load, which
// the inputs have to balance, is observed as d̂, so that it leaves no offset.
//
//   MLE_ASSIGN_OR_RETURN(Mpc mpc, Mpc::Create(model, options));
//   mpc.MeasureDisturbances(disturbances);  // if there are any
//   mpc.Step(measured_outputs, set_points, next_inputs);
//
// f is carried from instant to instant (free_response.h). Inputs of the role
// "disturbance" are not the controller's: it returns zero for them and moves
// the m_c others.
//
// Of a process model with transforms (mle/model/transform.h) all of this is
// done in the variables in which it is linear; measurements, set points, inputs
// and limits are engineering values, weights those at the operating point.
//
// Measurements, set points and disturbances that are not finite are taken as
// missing: the last ones hold.

#ifndef CONTROL_MPC_H_
#define CONTROL_MPC_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "control/disturbance_observer.h"
#include "control/engineering_variables.h"
#include "control/free_response.h"
#include "control/move_planner.h"
#include "control/mpc_options.h"
#include "control/prediction_model.h"
#include "mle/model/process_model.h"

namespace mle::control {

class Mpc {
 public:
  // At rest: all past inputs zero, those with a transform at its operating
  // point, no disturbance observed.
  //
  // InvalidArgument for an invalid model or option, a model of another control
  // period, without a manipulated input, or that settles so slowly that its
  // step responses would hold over 10⁸ values, and a Hessian that is not
  // positive definite.
  static absl::StatusOr<Mpc> Create(const PredictionModel& model,
                                    const MpcOptions& options);
  static absl::StatusOr<Mpc> Create(const ProcessModel& model,
                                    const MpcOptions& options);

  // m_c × p H_p: Δu_1 is its product with the stacked errors
  // r − f_{l+i} − ŵ − i d̂, i = 1 … H_p, as long as no limit is met.
  const Eigen::MatrixXd& gain() const { return planner_.gain(); }
  const DisturbanceObserver& observer() const { return observer_; }
  const PredictionModel& model() const { return model_; }
  const MpcOptions& options() const { return options_; }

  // f + ŵ (p) at the coming instant.
  Eigen::VectorXd PredictedOutputs() const;
  // How the last control instant went.
  const PlanSummary& last_plan() const { return last_plan_; }

  // Starts again as if `inputs` (m) had stood for ever and the outputs had come
  // to rest at `outputs` (p).
  void Restart(const Eigen::Ref<const Eigen::VectorXd>& inputs,
               const Eigen::Ref<const Eigen::VectorXd>& outputs);

  // Sets the inputs of the role "disturbance" from this instant on (in their
  // order); the effect of a change is fed forward. To be called before Step().
  void MeasureDisturbances(
      const Eigen::Ref<const Eigen::VectorXd>& disturbances);

  // One control instant; fills `next_inputs` (m). Allocates nothing.
  void Step(const Eigen::Ref<const Eigen::VectorXd>& measured_outputs,
            const Eigen::Ref<const Eigen::VectorXd>& set_points,
            Eigen::Ref<Eigen::VectorXd> next_inputs);

  // With set points known ahead: column i − 1 of `set_points` (p × H_p) holds
  // at instant l+i; that of an integrating output at l+H_p is not used.
  void StepWithPreview(
      const Eigen::Ref<const Eigen::VectorXd>& measured_outputs,
      const Eigen::Ref<const Eigen::MatrixXd>& set_points,
      Eigen::Ref<Eigen::VectorXd> next_inputs);

  // Continues with another model and other options between two instants. The
  // inputs stay; the free response is that of the new model to the inputs so
  // far, and the disturbance estimate absorbs the difference, of integrating
  // outputs that of slopes too, so that the predicted outputs of the coming
  // instant stay: a loop at rest at its set point remains at rest.
  //
  // The transforms of channels stay. InvalidArgument, and nothing changed, for
  // what Create() refuses and for other numbers or roles of inputs and outputs,
  // or another control period.
  absl::Status ExchangeModel(const PredictionModel& model,
                             const MpcOptions& options);

 private:
  Mpc(PredictionModel model, MpcOptions options, MovePlanner planner);

  static absl::StatusOr<Mpc> CreateAtRest(PredictionModel model,
                                          const MpcOptions& options);
  void PlanAndMove(const Eigen::Ref<const Eigen::VectorXd>& measured_outputs,
                   Eigen::Ref<Eigen::VectorXd> next_inputs);
  void HoldLastSetPoints();
  void RebuildFreeResponse();

  EngineeringVariables variables_;
  PredictionModel model_;  // reaching at least to H_p
  MpcOptions options_;
  MovePlanner planner_;
  DisturbanceObserver observer_;
  std::vector<int> manipulated_;   // the m_c inputs that are moved
  std::vector<int> disturbances_;  // the others

  FreeResponse free_response_;
  Eigen::VectorXd inputs_;              // sent last (m_c)
  Eigen::VectorXd disturbance_inputs_;  // measured last (m − m_c)
  // m × depth, a ring: column newest_ is what acts from the coming instant on.
  Eigen::MatrixXd history_;
  Eigen::Index newest_ = 0;

  Eigen::VectorXd set_points_;  // the last finite ones, of each instant: p H_p
  Eigen::VectorXd predicted_;   // of the measured outputs (p)
  Eigen::VectorXd measured_;    // these (p)
  Eigen::VectorXd wanted_;      // set points of an instant (p)
  Eigen::VectorXd free_outputs_;  // p H_p
  Eigen::VectorXd error_;         // p H_p
  PlanSummary last_plan_;
};

}  // namespace mle::control

#endif  // CONTROL_MPC_H_
