// Model predictive control without constraints (the paper's Eq. 4–5).
//
// At control instant l the moves Δu_1 … Δu_{H_c} minimise
//
//   J = Σ_{i=1}^{H_p} ‖r_l − ŷ_{l+i}‖²_{Q_y} + Σ_{i=1}^{H_c} ‖Δu_i‖²_{Q_u},
//   ŷ_{l+i} = f_{l+i} + ŵ_l + Σ_{j=1}^{min(i, H_c)} S_{i−j} Δu_j,
//
// where S_i is the model's step response at iΔt_c (S_0 = 0: move j acts from
// instant l+j on), f its free response to the inputs sent so far and ŵ the
// observed disturbance. The set point is taken to stay where it is. u_{l} +
// Δu_1 acts from instant l+1. The minimiser is linear in the predicted error,
// so one instant costs one product with a gain made beforehand.
//
//   MLE_ASSIGN_OR_RETURN(Mpc mpc, Mpc::Create(model, options));
//   mpc.Step(measured_outputs, set_points, next_inputs);
//
// f is carried from instant to instant: shifted by one, plus the step response
// to the move just decided (dynamic matrix control: Cutler and Ramaker, Joint
// Automatic Control Conference, 1980). Inputs of the role "disturbance" are
// not the controller's: it leaves them at zero and moves the m_c others.

#ifndef CONTROL_MPC_H_
#define CONTROL_MPC_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "control/disturbance_observer.h"
#include "mle/model/process_model.h"

namespace mle::control {

struct MpcOptions {
  double control_period = 1.0;  // Δt_c > 0, in the model's time unit
  int prediction_horizon = 30;  // H_p ≥ H_c, in control periods
  int control_horizon = 5;      // H_c ≥ 1, in control periods
  // Symmetric and positive semi-definite; p × p and m × m, where the rows and
  // columns of disturbances are not used. The Hessian they give must be
  // positive definite.
  Eigen::MatrixXd output_weight;  // Q_y
  Eigen::MatrixXd move_weight;    // Q_u
  // ρ ∈ [0, ∞] of the DisturbanceObserver.
  double disturbance_variance_ratio = 0.1;

  absl::Status Validate(int num_outputs, int num_inputs) const;
};

class Mpc {
 public:
  // At rest: all past inputs zero, no disturbance observed.
  //
  // InvalidArgument for an invalid model or option, a model without a
  // manipulated input, a Hessian that is not positive definite, and a model
  // that settles so slowly that its step responses would hold over 10⁸ values.
  static absl::StatusOr<Mpc> Create(const ProcessModel& model,
                                    const MpcOptions& options);

  // m_c × p H_p: Δu_1 is its product with the stacked errors r − f_{l+i} − ŵ,
  // i = 1 … H_p.
  const Eigen::MatrixXd& gain() const { return gain_; }

  // Instants over which the free response is carried: at least H_p, and until
  // the model has settled to about 1e-11 of its gains.
  int settling_periods() const {
    return static_cast<int>(free_response_.size() / num_outputs_) - 1;
  }

  // One control instant; fills `next_inputs` (m). Allocates nothing.
  void Step(const Eigen::Ref<const Eigen::VectorXd>& measured_outputs,
            const Eigen::Ref<const Eigen::VectorXd>& set_points,
            Eigen::Ref<Eigen::VectorXd> next_inputs);

 private:
  Mpc(int num_outputs, int num_inputs, double disturbance_variance_ratio);

  int num_outputs_ = 0;           // p
  int num_inputs_ = 0;            // m
  std::vector<int> manipulated_;  // the m_c inputs that are moved
  Eigen::MatrixXd gain_;
  // S_0; …; S_n, one below the other: p(n+1) × m_c.
  Eigen::MatrixXd step_responses_;

  DisturbanceObserver observer_;
  Eigen::VectorXd free_response_;  // f_l; …; f_{l+n}: p(n+1)
  Eigen::VectorXd inputs_;         // sent last (m_c)
  Eigen::VectorXd error_;          // p H_p
  Eigen::VectorXd move_;           // m_c
};

}  // namespace mle::control

#endif  // CONTROL_MPC_H_
