// Evaluation of a model against the true plant. Only simulations know the
// plant; the correction itself never sees it.

#ifndef MLE_CORRECTION_JUDGEMENT_H_
#define MLE_CORRECTION_JUDGEMENT_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/step_response.h"
#include "mle/nonlinear/low_order_fit.h"

namespace mle {

struct Judgement {
  double squared_distance = 0.0;  // E(M, M̂)
  // p × m: last sample of the model's step responses less the truth's.
  Eigen::MatrixXd static_gain_error;
  // p × m: dead time read at the peak of the impulse response.
  Eigen::MatrixXd delay_impulse_peak;
  // First-order-plus-dead-time fits, row by row (p·m).
  std::vector<FopdtFit> fopdt;
};

// Both responses of the same shape.
absl::StatusOr<Judgement> Judge(const StepResponse& truth,
                                const StepResponse& model);

}  // namespace mle

#endif  // MLE_CORRECTION_JUDGEMENT_H_
