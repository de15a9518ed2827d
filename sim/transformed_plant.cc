#include "sim/transformed_plant.h"

#include <utility>

namespace mle::sim {

TransformedPlant::TransformedPlant(std::unique_ptr<PlantModel> linear,
                                   const ProcessModel& model)
    : linear_(std::move(linear)),
      inputs_(Eigen::VectorXd::Zero(model.num_inputs())),
      outputs_(Eigen::VectorXd::Zero(model.num_outputs())) {
  for (const InputChannel& input : model.inputs()) {
    input_transforms_.push_back(input.transform);
  }
  for (const OutputChannel& output : model.outputs()) {
    output_transforms_.push_back(output.transform);
  }
  ShowOutputs();
}

void TransformedPlant::Advance(const Eigen::Ref<const Eigen::VectorXd>& input) {
  for (Eigen::Index j = 0; j < input.size(); ++j) {
    const Transform& transform = input_transforms_[j];
    inputs_[j] = transform.Linear(transform.at + input[j]) - transform.at;
  }
  linear_->Advance(inputs_);
  ShowOutputs();
}

void TransformedPlant::ShowOutputs() {
  const Eigen::VectorXd& z = linear_->outputs();
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const Transform& transform = output_transforms_[i];
    outputs_[i] = transform.Engineering(transform.at + z[i]) - transform.at;
  }
}

}  // namespace mle::sim
