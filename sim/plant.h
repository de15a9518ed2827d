// A plant made of transfer functions with dead time, under inputs that are
// held between samples (zero-order hold).
//
// Every element is realised as ẋ = A x + B u(t − L), y = C x + D u(t − L) and
// integrated by the classical fourth-order Runge–Kutta scheme in fixed fine
// steps. A dead time is kept exactly: with L = (q + f) Δt, 0 ≤ f < 1, the
// element sees u_{k−q−1} during the first fΔt of sample k and u_{k−q} during
// the rest, and no step crosses that change. An f within 1e-9 of 0 or 1 is
// taken as the whole sample.
//
//   MLE_ASSIGN_OR_RETURN(Plant plant, Plant::Create(model, {.sample_time =
//   0.2})); plant.Advance(u);      // hold u from now to the next sample
//   plant.outputs();       // just before the input may change again
//
// One sample costs two products of the size of its state for each element, no
// matter how fine the steps: they are composed once (held_input_map.h).

#ifndef SIM_PLANT_H_
#define SIM_PLANT_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "sim/held_input_map.h"
#include "sim/plant_model.h"

namespace mle::sim {

struct PlantOptions {
  // Δt > 0, in the model's time unit.
  double sample_time = 0.2;
  // Largest integration step as a fraction of the fastest time constant of the
  // element (the inverse of the magnitude of its largest pole), in (0, 1]:
  // where the scheme is stable for every stable element. The relative error of
  // a step response is about its fourth power / 120.
  double relative_step = 0.01;

  absl::Status Validate() const;
};

class Plant final : public PlantModel {
 public:
  // At rest, with all past inputs zero. InvalidArgument for an invalid model or
  // option, and where a dead time is longer than 10⁷ samples or an integration
  // step would be shorter than 10⁻¹⁵ samples.
  static absl::StatusOr<Plant> Create(const ProcessModel& model,
                                      const PlantOptions& options);

  int num_inputs() const override { return static_cast<int>(history_.rows()); }
  int num_outputs() const override { return static_cast<int>(outputs_.size()); }

  // Holds `input` (m) from the present sample to the next one and goes there.
  // Allocates nothing.
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) override;

  // y (p) at the present sample, without measurement noise.
  const Eigen::VectorXd& outputs() const override { return outputs_; }

 private:
  // An element of the model that is not zero.
  struct Element {
    int output = 0;
    int input = 0;
    int whole_delay = 0;      // q
    bool has_split = false;   // f > 0
    HeldInputMap first_part;  // fΔt; unused without a split
    HeldInputMap rest;        // (1 − f)Δt
    Eigen::RowVectorXd C;
    double D = 0.0;
    Eigen::VectorXd state;
    Eigen::VectorXd next_state;
  };

  Plant() = default;
  static absl::StatusOr<Element> MakeElement(const TransferFunction& transfer,
                                             const PlantOptions& options);
  // The held input of `input` that began `age` samples before the present one.
  double PastInput(int input, int age) const;

  std::vector<Element> elements_;
  Eigen::MatrixXd history_;  // m × depth, a ring: column newest_ is u_k
  int newest_ = 0;
  Eigen::VectorXd outputs_;
};

}  // namespace mle::sim

#endif  // SIM_PLANT_H_
