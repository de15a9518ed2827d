// Conversion of a process model into an ARX model, from a record of its
// response to an excitation (the paper's Eq. 1):
//
//   R = argmin 1/(2N) ‖Y₀ − R X₀‖_F² + λ₀ ‖R‖₁.
//
// The record must carry the measurement noise of the plant the model will be
// corrected on. Without it R becomes a nearly pure autoregression, which
// doubles the noise in its predictions and hides the mismatch (docs/method.md).

#ifndef MLE_CORRECTION_CONVERSION_H_
#define MLE_CORRECTION_CONVERSION_H_

#include <functional>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

struct ConversionOptions {
  int order = 150;        // d ≥ 1
  double penalty = 1e-6;  // λ₀ ≥ 0
  Scaling scaling = Scaling::kStandardise;
  LassoSolverOptions solver;

  absl::Status Validate() const;
};

struct ConversionSummary {
  ArxModel model;
  double max_relative_gap = 0.0;
  // p: mean square of the one-step prediction error on the record.
  Eigen::VectorXd residual_variance;
};

// Brings the record of the excited model and converts it.
using ArxConverter =
    std::function<absl::StatusOr<ConversionSummary>(const ProcessModel& model)>;

absl::StatusOr<ConversionSummary> ConvertToArx(
    const Record& excitation, const ConversionOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_CONVERSION_H_
