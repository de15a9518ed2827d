#include "mle/correction/judgement.h"

#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle {

absl::StatusOr<Judgement> Judge(const StepResponse& truth,
                                const StepResponse& model) {
  CHECK_EQ(truth.values.rows(), model.values.rows());
  CHECK_EQ(truth.values.cols(), model.values.cols());
  Judgement judgement;
  judgement.squared_distance = SquaredDistance(truth, model);
  judgement.static_gain_error = FinalValues(model) - FinalValues(truth);
  judgement.delay_impulse_peak = ImpulsePeakTimes(model);
  for (int i = 0; i < model.num_outputs; ++i) {
    for (int j = 0; j < model.num_inputs; ++j) {
      MLE_ASSIGN_OR_RETURN(
          FopdtFit fit,
          FitFopdt(model.element(i, j), model.sample_time, FopdtOptions()));
      judgement.fopdt.push_back(fit);
    }
  }
  return judgement;
}

}  // namespace mle
