// Whether the outputs answer what a record says an input did for one sample.
// Internal to mle/maintain.
//
// A controller's kick, at a change of set point or some samples after it, and a
// fault of the historian look alike in the input. With h the model's
// response of output i to the input by `size` for that sample, and e = y − G u
// the residual under the inputs as recorded, around the sample
//
//   e_i(n) = α + β n + d h_i(n) + noise,
//
// where d is 0 if the plant saw the move, and −1 if only the record did. With d
// of all outputs together, each by its residual variance, the share that was
// answered is 1 + d.

#ifndef MLE_MAINTAIN_ANSWERED_MOVES_H_
#define MLE_MAINTAIN_ANSWERED_MOVES_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle {

class AnsweredMoves {
 public:
  // `record` is of the model's channels. Errors as of SimulateResponse().
  static absl::StatusOr<AnsweredMoves> Create(const ProcessModel& model,
                                              const Record& record);

  // The share that the outputs answer of the model's response to `input` moved
  // by `size` for `sample` alone; 0 where the outputs do not tell.
  double Share(int input, int sample, double size) const;

 private:
  AnsweredMoves() = default;

  Eigen::MatrixXd residual_;  // p × N, y − G u
  StepResponse steps_;
};

}  // namespace mle

#endif  // MLE_MAINTAIN_ANSWERED_MOVES_H_
