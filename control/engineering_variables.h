// The variables of a loop in engineering values, and those in which a model
// with transforms is linear (mle/model/transform.h): a controller plans in the
// latter, and measures, moves and is limited in the former.

#ifndef CONTROL_ENGINEERING_VARIABLES_H_
#define CONTROL_ENGINEERING_VARIABLES_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "control/mpc_options.h"
#include "mle/model/process_model.h"

namespace mle::control {

class EngineeringVariables {
 public:
  EngineeringVariables() = default;
  explicit EngineeringVariables(const ProcessModel& model);

  bool has_transforms() const { return !inputs_.empty(); }

  // Limits in linear variables. A limit of moves is the one that holds wherever
  // the input is: it takes the least slope between the input's limits. Inputs
  // without limits have those of their curve: a valve is closed or open.
  // InvalidArgument, naming the channel, for a limit without a transform, and
  // for limited moves of an input without limits.
  absl::StatusOr<MpcLimits> LinearLimits(const MpcLimits& limits) const;

  // In place, from engineering values to linear ones (NaN where a value has
  // none) and back. Nothing without transforms; allocates nothing.
  void LinearInputs(Eigen::Ref<Eigen::VectorXd> inputs) const;    // m
  void LinearOutputs(Eigen::Ref<Eigen::VectorXd> outputs) const;  // p
  double LinearInput(int input, double value) const;
  void Inputs(Eigen::Ref<Eigen::VectorXd> inputs) const;
  void Outputs(Eigen::Ref<Eigen::VectorXd> outputs) const;

  // Where the transforms have the slope 1; 0 of channels without one.
  Eigen::VectorXd OperatingInputs() const;
  Eigen::VectorXd OperatingOutputs() const;

 private:
  struct Channel {
    std::string name;
    Transform transform;
  };
  std::vector<Channel> inputs_;  // empty: no channel has a transform
  std::vector<Channel> outputs_;
};

}  // namespace mle::control

#endif  // CONTROL_ENGINEERING_VARIABLES_H_
