// Fits that several estimates of one model from the same windows have in
// common: studies compare estimators, tests and rules for λ on the same
// records, and each fit is made once, when it is first asked for.
//
//   SharedFits fits;
//   EstimateModel(model, windows, arx_by_blocks, {}, &fits);
//   EstimateModel(model, windows, arx_by_bic, {}, &fits);   // the path is
//   there
//
// The options of such estimates may differ in estimator, change_test,
// solve_by_ceres and correction.selection, and in nothing else.

#ifndef MLE_MAINTAIN_SHARED_FITS_H_
#define MLE_MAINTAIN_SHARED_FITS_H_

#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/correction/correction.h"
#include "mle/maintain/estimation.h"
#include "mle/nonlinear/model_adequacy.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// Seconds of processor time of this thread.
double ThreadSeconds();

// A result that is made when first asked for, and how long that took.
template <typename T>
class Shared {
 public:
  // A result that was there already adds its time to `reused_seconds`.
  template <typename Make>
  absl::StatusOr<const T*> Get(const Make& make, double& reused_seconds) {
    if (result_.has_value()) {
      reused_seconds += seconds_;
    } else {
      const double start = ThreadSeconds();
      result_ = make();
      seconds_ = ThreadSeconds() - start;
    }
    if (!result_->ok()) return result_->status();
    return &**result_;
  }

 private:
  std::optional<absl::StatusOr<T>> result_;
  double seconds_ = 0.0;
};

struct SharedFits {
  Shared<OutputErrorCorrection> output_error;  // before the calibration
  Shared<NullCalibration> calibration;
  Shared<ModelAdequacy> adequacy;  // of the initial model
  Shared<Correction> arx;          // around R of the initial model
};

}  // namespace mle

#endif  // MLE_MAINTAIN_SHARED_FITS_H_
