// A plant given by differential equations with dead times in its inputs:
//
//   ẋ = f(t, x, w),   y = h(t, x, w),   w_i(t) = u⁰ + u_{j_i}(t − L_i(t)),
//
// with x: n states, u: m inputs held between samples, y: p outputs, w: the
// inputs as they arrive on q paths (delayed_inputs.h). The general linear plant
// with several delays is one such (linear_system.h), plants of the literature
// are others (plant_at_rest.h).
//
// Integrated by the classical fourth-order Runge–Kutta scheme in fine steps. No
// step crosses a jump of an input or one of `breaks`; between those f and h may
// depend on time in any smooth way.
//
// Inputs and outputs of the plant are deviations from `input_origin` and
// `output_origin`, which is what a process model and a controller deal in.
//
//   ContinuousSystem tank{.num_inputs = 1, .num_outputs = 1};
//   tank.derivative = [](double, const auto& x, const auto& w, auto& dx) {
//     dx[0] = w[0] - 0.5 * std::sqrt(x[0]);
//   };
//   tank.output = [](double, const auto& x, const auto&, auto& y) { y = x; };
//   tank.initial_state = Eigen::VectorXd::Constant(1, 4.0);
//   tank.input_origin = Eigen::VectorXd::Constant(1, 1.0);
//   tank.output_origin = Eigen::VectorXd::Constant(1, 4.0);
//   tank.largest_step = 0.1;
//   MLE_ASSIGN_OR_RETURN(auto plant, ContinuousPlant::Create(tank, {}));

#ifndef SIM_CONTINUOUS_PLANT_H_
#define SIM_CONTINUOUS_PLANT_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "sim/delayed_inputs.h"
#include "sim/plant_model.h"
#include "sim/runge_kutta.h"

namespace mle::sim {

// (t, x (n), w (q), result, sized on entry: n for f, p for h).
using SystemFunction =
    std::function<void(double time, const Eigen::VectorXd& state,
                       const Eigen::VectorXd& inputs, Eigen::VectorXd& result)>;

struct ContinuousSystem {
  int num_inputs = 0;   // m ≥ 1
  int num_outputs = 0;  // p ≥ 1
  // Empty: every input on a path of its own, without dead time.
  std::vector<InputPath> paths;
  SystemFunction derivative;      // f
  SystemFunction output;          // h
  Eigen::VectorXd initial_state;  // n ≥ 0
  Eigen::VectorXd input_origin;   // u⁰ (m); empty: zero
  Eigen::VectorXd output_origin;  // y⁰ (p); empty: zero
  // Largest integration step > 0, in time units. With λ the eigenvalue of ∂f/∂x
  // of largest magnitude, the scheme is stable up to about 2.5/|λ| and has a
  // relative error of about (step |λ|)⁴ / 120.
  double largest_step = 0.0;
  // Times at which f or h jump or have a kink, in any order. They are then
  // evaluated on the side of the break that a step is on.
  std::vector<double> breaks;

  absl::Status Validate() const;
};

struct ContinuousPlantOptions {
  double sample_time = 0.2;  // Δt > 0
  double start_time = 0.0;   // t of the first sample
};

class ContinuousPlant final : public PlantModel {
 public:
  // In its initial state, with all past inputs at their origin.
  static absl::StatusOr<ContinuousPlant> Create(
      ContinuousSystem system, const ContinuousPlantOptions& options);

  int num_inputs() const override { return inputs_.num_inputs(); }
  int num_outputs() const override { return system_.num_outputs; }
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) override;
  const Eigen::VectorXd& outputs() const override { return outputs_; }

  const Eigen::VectorXd& state() const { return state_; }
  double time() const;  // of the present sample

 private:
  ContinuousPlant(ContinuousSystem system, DelayedInputs inputs,
                  const ContinuousPlantOptions& options);
  void FindBreaks();
  void Integrate(double from, double to);
  double InsideBreaks(double from, double to, double at) const;
  void ComputeOutputs(double at_time);

  ContinuousSystem system_;
  DelayedInputs inputs_;
  ContinuousPlantOptions options_;
  std::int64_t sample_ = 0;
  RungeKutta4<Eigen::VectorXd> scheme_;
  Eigen::VectorXd state_;
  Eigen::VectorXd path_inputs_;  // w
  Eigen::VectorXd outputs_;
  // Breaks in the present sample as fractions of it, its ends included where
  // they are breaks.
  std::vector<double> breaks_;
};

}  // namespace mle::sim

#endif  // SIM_CONTINUOUS_PLANT_H_
