// A transfer matrix whose elements age while it runs (ageing.h).
//
// Elements that do not age go the fast way of Plant; every ageing element is
// integrated by itself, so that the cost is linear in elements and samples.
//
//   MLE_ASSIGN_OR_RETURN(AgeingPlant plant,
//                        AgeingPlant::Create(model, ageing,
//                                            {.sample_time = 0.2,
//                                             .start_time = 525600.0}));

#ifndef SIM_AGEING_PLANT_H_
#define SIM_AGEING_PLANT_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"
#include "sim/continuous_plant.h"
#include "sim/plant.h"
#include "sim/plant_model.h"

namespace mle::sim {

struct AgeingPlantOptions {
  double sample_time = 0.2;  // Δt > 0
  // Time of the schedule at the first sample: how old the plant is.
  double start_time = 0.0;
};

class AgeingPlant final : public PlantModel {
 public:
  // At rest, with all past inputs zero.
  static absl::StatusOr<AgeingPlant> Create(const ProcessModel& model,
                                            const AgeingSchedule& ageing,
                                            const AgeingPlantOptions& options);

  int num_inputs() const override { return steady_part_.num_inputs(); }
  int num_outputs() const override { return steady_part_.num_outputs(); }
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) override;
  const Eigen::VectorXd& outputs() const override { return outputs_; }

 private:
  struct Element {
    int output = 0;
    int input = 0;
    ContinuousPlant plant;
  };

  AgeingPlant(Plant steady_part, std::vector<Element> elements);

  Plant steady_part_;
  std::vector<Element> elements_;
  Eigen::VectorXd outputs_;
};

}  // namespace mle::sim

#endif  // SIM_AGEING_PLANT_H_
