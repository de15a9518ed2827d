// A plant made of transfer functions with dead time: the exact response of
// mle/model/process_simulator.h behind the interface of all plants.
//
//   MLE_ASSIGN_OR_RETURN(Plant plant,
//                        Plant::Create(model, {.sample_time = 0.2}));

#ifndef SIM_PLANT_H_
#define SIM_PLANT_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "mle/model/process_simulator.h"
#include "sim/plant_model.h"

namespace mle::sim {

struct PlantOptions {
  double sample_time = 0.2;  // Δt > 0, in the model's time unit
};

class Plant final : public PlantModel {
 public:
  // At rest, with all past inputs zero. Errors are those of
  // ProcessSimulator::Create().
  static absl::StatusOr<Plant> Create(const ProcessModel& model,
                                      const PlantOptions& options);

  int num_inputs() const override { return simulator_.num_inputs(); }
  int num_outputs() const override { return simulator_.num_outputs(); }
  // Allocates nothing.
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) override {
    simulator_.Advance(input);
  }
  const Eigen::VectorXd& outputs() const override {
    return simulator_.outputs();
  }

 private:
  explicit Plant(ProcessSimulator simulator);

  ProcessSimulator simulator_;
};

}  // namespace mle::sim

#endif  // SIM_PLANT_H_
