// A plant whose channels have transforms (mle/model/transform.h), made of one
// that is linear between the transformed variables.
//
// Inputs and outputs are deviations from the operating point of the transforms,
// as everywhere in simulations: of a channel with a transform x − a,
//
//   v = T(a + u) − a,   y = T⁻¹(a + z) − a,
//
// v the linear plant's input and z its output.

#ifndef SIM_TRANSFORMED_PLANT_H_
#define SIM_TRANSFORMED_PLANT_H_

#include <memory>
#include <vector>

#include "Eigen/Core"
#include "mle/model/process_model.h"
#include "sim/plant_model.h"

namespace mle::sim {

class TransformedPlant final : public PlantModel {
 public:
  // `linear` has the channels of `model`, whose transforms are valid.
  TransformedPlant(std::unique_ptr<PlantModel> linear,
                   const ProcessModel& model);

  int num_inputs() const override { return linear_->num_inputs(); }
  int num_outputs() const override { return linear_->num_outputs(); }
  // Allocates nothing. Outputs are not finite where z has no y.
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) override;
  const Eigen::VectorXd& outputs() const override { return outputs_; }

 private:
  void ShowOutputs();

  std::unique_ptr<PlantModel> linear_;
  std::vector<Transform> input_transforms_;
  std::vector<Transform> output_transforms_;
  Eigen::VectorXd inputs_;
  Eigen::VectorXd outputs_;
};

}  // namespace mle::sim

#endif  // SIM_TRANSFORMED_PLANT_H_
