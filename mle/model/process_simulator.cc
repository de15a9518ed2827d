#include "mle/model/process_simulator.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle {

absl::StatusOr<ProcessSimulator> ProcessSimulator::Create(
    const ProcessModel& model, double sample_time) {
  MLE_RETURN_IF_ERROR(model.Validate());
  // A model without elements has no other place for this check.
  MLE_RETURN_IF_ERROR(
      HeldResponse::Create(TransferFunction(), sample_time).status());
  ProcessSimulator simulator;
  int longest_delay = 0;
  for (const auto& [i, j] : Pairs(model)) {
    if (model.element(i, j).IsZero()) continue;
    absl::StatusOr<HeldResponse> response =
        HeldResponse::Create(model.element(i, j), sample_time);
    if (!response.ok()) {
      return absl::Status(response.status().code(),
                          absl::StrCat("element (", model.outputs()[i].name,
                                       ", ", model.inputs()[j].name,
                                       "): ", response.status().message()));
    }
    Element& element = simulator.elements_.emplace_back();
    element.output = i;
    element.input = j;
    element.response = *std::move(response);
    element.state = Eigen::VectorXd::Zero(element.response.map.E.rows());
    element.move = element.state;
    longest_delay = std::max(longest_delay, element.response.whole_delay);
  }
  simulator.history_ =
      Eigen::MatrixXd::Zero(model.num_inputs(), longest_delay + 2);
  simulator.outputs_ = Eigen::VectorXd::Zero(model.num_outputs());
  return simulator;
}

void ProcessSimulator::Advance(const Eigen::Ref<const Eigen::VectorXd>& input) {
  CHECK_EQ(input.size(), history_.rows());
  newest_ = newest_ + 1 == history_.cols() ? 0 : newest_ + 1;
  history_.col(newest_) = input;
  outputs_.setZero();
  for (Element& element : elements_) {
    const HeldResponse& response = element.response;
    const double newer = PastInput(element.input, response.whole_delay);
    const double older = PastInput(element.input, response.whole_delay + 1);
    element.move = response.map.E.lazyProduct(element.state) +
                   response.map.older * older + response.map.newer * newer;
    element.state += element.move;
    outputs_[element.output] +=
        response.C.dot(element.state) + response.D * newer;
  }
}

double ProcessSimulator::PastInput(int input, int age) const {
  const int column = newest_ - age;
  return history_(
      input, column < 0 ? column + static_cast<int>(history_.cols()) : column);
}

absl::StatusOr<Eigen::MatrixXd> SimulateResponse(
    const ProcessModel& model, double sample_time,
    const Eigen::MatrixXd& inputs) {
  MLE_ASSIGN_OR_RETURN(ProcessSimulator simulator,
                       ProcessSimulator::Create(model, sample_time));
  if (inputs.rows() != model.num_inputs()) {
    return InvalidArgument("inputs has ", inputs.rows(),
                           " rows, but the model has ", model.num_inputs(),
                           " inputs");
  }
  Eigen::MatrixXd outputs(model.num_outputs(), inputs.cols());
  if (inputs.cols() == 0) return outputs;
  const Eigen::VectorXd start = inputs.col(0);
  const Eigen::MatrixXd gains =
      (IntegrationOrders(model).array() > 0).select(0.0, StaticGains(model));
  const Eigen::VectorXd settled = gains * start;
  for (Eigen::Index k = 0; k < outputs.cols(); ++k) {
    outputs.col(k) = settled + simulator.outputs();
    simulator.Advance(inputs.col(k) - start);
  }
  return outputs;
}

}  // namespace mle
