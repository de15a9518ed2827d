// A process model: a p × m matrix of transfer functions with named inputs and
// outputs,
//
//   y_i(s) = Σ_j g_ij(s) u_j(s),
//
// between transformed variables where a channel has a transform (transform.h).
//
// The JSON form is described in docs/formats.md:
//
//   MLE_ASSIGN_OR_RETURN(const ProcessModel model,
//                        ReadProcessModel("configs/wood_berry.json"));
//   model.element(0, 1).StaticGain();   // −18.9

#ifndef MLE_MODEL_PROCESS_MODEL_H_
#define MLE_MODEL_PROCESS_MODEL_H_

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/step_response.h"
#include "mle/model/transfer_function.h"
#include "mle/model/transform.h"

namespace mle {

enum class InputRole { kManipulated, kDisturbance };

// What is known of the samples of a channel, in the model's time unit; 0: as
// the rows of the records have it.
struct Sampling {
  // Outputs: measured so often, as by a laboratory, and whether the last value
  // is repeated until the next.
  double period = 0.0;
  bool held = false;
  double late_by = 0.0;  // stamps are later than the samples; < 0: earlier
  // Samples are means over this time, stamped at its start or at its end.
  double average = 0.0;
  bool stamped_at_end = false;

  // By how much the stamps are late: of the middle of what an output was
  // averaged over, of the start of what an input was.
  double OutputLate() const {
    return late_by + (stamped_at_end ? 0.5 : -0.5) * average;
  }
  double InputLate() const {
    return late_by + (stamped_at_end ? average : 0.0);
  }
  bool operator==(const Sampling& other) const = default;
};

struct InputChannel {
  std::string name;
  std::string unit;
  InputRole role = InputRole::kManipulated;
  Sampling sampling = {};
  Transform transform = {};
};

struct OutputChannel {
  std::string name;
  std::string unit;
  Sampling sampling = {};
  Transform transform = {};
};

class ProcessModel {
 public:
  ProcessModel() = default;
  // All elements zero.
  ProcessModel(std::string name, std::string time_unit,
               std::vector<InputChannel> inputs,
               std::vector<OutputChannel> outputs);

  // At least one input and output, names not empty and distinct over inputs
  // and outputs, every element and transform valid.
  absl::Status Validate() const;

  const std::string& name() const { return name_; }
  const std::string& time_unit() const { return time_unit_; }
  const std::vector<InputChannel>& inputs() const { return inputs_; }
  const std::vector<OutputChannel>& outputs() const { return outputs_; }
  void set_input_transform(int input, Transform transform) {
    inputs_[input].transform = std::move(transform);
  }
  void set_output_transform(int output, Transform transform) {
    outputs_[output].transform = std::move(transform);
  }
  int num_inputs() const { return static_cast<int>(inputs_.size()); }
  int num_outputs() const { return static_cast<int>(outputs_.size()); }

  const TransferFunction& element(int output, int input) const {
    return elements_[output * num_inputs() + input];
  }
  TransferFunction& element(int output, int input) {
    return elements_[output * num_inputs() + input];
  }

  // Responses of all pairs at 0, Δt, …, (samples−1) Δt.
  StepResponse ComputeStepResponse(double sample_time, int samples) const;

 private:
  std::string name_;
  std::string time_unit_;
  std::vector<InputChannel> inputs_;
  std::vector<OutputChannel> outputs_;
  std::vector<TransferFunction> elements_;  // row by row: p × m
};

// Same inputs and outputs, by name and order, and the same time unit; the
// status says which differ. `a` and `b` are named in it by `a_name`, `b_name`.
absl::Status CheckSameChannels(const ProcessModel& a, std::string_view a_name,
                               const ProcessModel& b, std::string_view b_name);

// p × m: the gains K_ij, of integrating elements slopes (transfer_function.h).
Eigen::MatrixXd StaticGains(const ProcessModel& model);

// p × m: orders of integration ν_ij, 0 or 1.
Eigen::MatrixXi IntegrationOrders(const ProcessModel& model);
// A channel has a transform.
bool HasTransforms(const ProcessModel& model);
// The model without them, linear at an operating point: gains times the slopes
// of inputs over those of outputs. `values` are of channels by name; the others
// are where their transform has the slope 1. InvalidArgument for a channel that
// is not there, and for a value without a transform; names the channel.
absl::StatusOr<ProcessModel> LinearAt(
    const ProcessModel& model, const std::map<std::string, double>& values);
// The same where each transform has the slope 1: elements as they are.
ProcessModel WithoutTransforms(ProcessModel model);
// The elements that are not zero.
int NumElements(const ProcessModel& model);
// An element integrates: of the model, of an output; p of them.
bool IsIntegrating(const ProcessModel& model);
bool IsIntegrating(const ProcessModel& model, int output);
std::vector<bool> IntegratingOutputs(const ProcessModel& model);
// InvalidArgument, naming the first pair that integrates and `what` cannot be
// made of it.
absl::Status CheckNotIntegrating(const ProcessModel& model,
                                 std::string_view what);

// A loop tuned on a level takes about this many times the sum of dead time and
// time constant (integral time and dead time of Skogestad's rules, 8 L and L:
// J. Process Control 13, 2003).
inline constexpr double kLevelSettlingTimes = 10.0;

// Dead time plus five times the slowest time constant of the slowest element:
// the remainder of a step's response is then 0.7 % of it. A level settles in
// its loop alone: of an integrating element kLevelSettlingTimes.
double SettlingTime(const ProcessModel& model);

// The names of inputs or outputs.
template <typename Channel>
std::vector<std::string> NamesOf(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const Channel& channel : channels) names.push_back(channel.name);
  return names;
}
std::vector<InputRole> InputRoles(const ProcessModel& model);

// The numbers of the outputs and inputs of all pairs, row by row.
struct PairPlace {
  int output = 0;
  int input = 0;
};
std::vector<PairPlace> Pairs(const ProcessModel& model);

// "overhead ← reflux": the pair as reports name it.
std::string PairName(const ProcessModel& model, int output, int input);

// `source` (a file's name) opens every message; unknown or missing keys, wrong
// types and invalid elements are errors that name key and element.
absl::StatusOr<ProcessModel> ParseProcessModel(std::string_view json,
                                               std::string_view source);
std::string FormatProcessModel(const ProcessModel& model);
absl::StatusOr<ProcessModel> ReadProcessModel(const std::string& path);
absl::Status WriteProcessModel(const ProcessModel& model,
                               const std::string& path);

}  // namespace mle

#endif  // MLE_MODEL_PROCESS_MODEL_H_
