#include "sim/ageing_plant.h"

#include <utility>

#include "mle/base/status.h"
#include "sim/linear_system.h"

namespace mle::sim {
namespace {

// One element as a process of its own.
absl::StatusOr<ContinuousPlant> ElementPlant(
    const TransferFunction& element, ElementAgeing ageing,
    const AgeingPlantOptions& options) {
  ProcessModel model("element", "", {{"input", ""}}, {{"output", ""}});
  model.element(0, 0) = element;
  ageing.output = ageing.input = 0;
  MLE_ASSIGN_OR_RETURN(ContinuousSystem system,
                       ToLinearSystem(model, {{std::move(ageing)}}));
  return ContinuousPlant::Create(
      std::move(system),
      {.sample_time = options.sample_time, .start_time = options.start_time});
}

}  // namespace

absl::StatusOr<AgeingPlant> AgeingPlant::Create(
    const ProcessModel& model, const AgeingSchedule& ageing,
    const AgeingPlantOptions& options) {
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(ageing.Validate(model));
  ProcessModel steady = model;
  std::vector<Element> elements;
  for (const ElementAgeing& one : ageing.elements) {
    MLE_ASSIGN_OR_RETURN(
        ContinuousPlant plant,
        ElementPlant(model.element(one.output, one.input), one, options));
    elements.push_back({one.output, one.input, std::move(plant)});
    steady.element(one.output, one.input) = TransferFunction();
  }
  MLE_ASSIGN_OR_RETURN(
      Plant steady_part,
      Plant::Create(steady, {.sample_time = options.sample_time}));
  return AgeingPlant(std::move(steady_part), std::move(elements));
}

AgeingPlant::AgeingPlant(Plant steady_part, std::vector<Element> elements)
    : steady_part_(std::move(steady_part)),
      elements_(std::move(elements)),
      outputs_(steady_part_.outputs()) {}

void AgeingPlant::Advance(const Eigen::Ref<const Eigen::VectorXd>& input) {
  steady_part_.Advance(input);
  outputs_ = steady_part_.outputs();
  for (Element& element : elements_) {
    element.plant.Advance(input.segment<1>(element.input));
    outputs_[element.output] += element.plant.outputs()[0];
  }
}

}  // namespace mle::sim
