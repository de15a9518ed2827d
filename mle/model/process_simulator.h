// The exact response of a process model to inputs that are held between samples
// (zero-order hold).
//
//   MLE_ASSIGN_OR_RETURN(ProcessSimulator simulator,
//                        ProcessSimulator::Create(model, /*sample_time=*/0.2));
//   simulator.Advance(u);     // hold u from now to the next sample
//   simulator.outputs();      // just before the input may change again
//
// Every element is a map from sample to sample (held_response.h): no step of an
// integration, no error but rounding. A sample costs one product of the size of
// its state for each element.

#ifndef MLE_MODEL_PROCESS_SIMULATOR_H_
#define MLE_MODEL_PROCESS_SIMULATOR_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/held_response.h"
#include "mle/model/process_model.h"

namespace mle {

class ProcessSimulator {
 public:
  // At rest, with all past inputs zero. `sample_time` Δt in the model's unit.
  // InvalidArgument for an invalid model or Δt, and for an element that has no
  // HeldResponse, which the message names.
  static absl::StatusOr<ProcessSimulator> Create(const ProcessModel& model,
                                                 double sample_time);

  int num_inputs() const { return static_cast<int>(history_.rows()); }
  int num_outputs() const { return static_cast<int>(outputs_.size()); }

  // Holds `input` (m) from the present sample to the next one and goes there.
  // Allocates nothing.
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input);

  // y (p) at the present sample.
  const Eigen::VectorXd& outputs() const { return outputs_; }

 private:
  // An element of the model that is not zero.
  struct Element {
    int output = 0;
    int input = 0;
    HeldResponse response;
    Eigen::VectorXd state;
    Eigen::VectorXd move;
  };

  ProcessSimulator() = default;
  // The held input of `input` that began `age` samples before the present one.
  double PastInput(int input, int age) const;

  std::vector<Element> elements_;
  Eigen::MatrixXd history_;  // m × depth, a ring: column newest_ is u_k
  int newest_ = 0;
  Eigen::VectorXd outputs_;
};

// The outputs (p × N) of the model to the inputs (m × N) held from sample to
// sample; before the first, the model is settled at the first inputs: these
// balance an integrating element, which stands at 0.
// InvalidArgument as ProcessSimulator::Create(), and where the rows of `inputs`
// are not the model's inputs.
absl::StatusOr<Eigen::MatrixXd> SimulateResponse(const ProcessModel& model,
                                                 double sample_time,
                                                 const Eigen::MatrixXd& inputs);

}  // namespace mle

#endif  // MLE_MODEL_PROCESS_SIMULATOR_H_
