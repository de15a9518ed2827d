#include "mle/maintain/withdrawal.h"

#include <algorithm>

#include "Eigen/Core"
#include "mle/base/status.h"
#include "mle/maintain/corrected_model.h"
#include "mle/maintain/stamps.h"

namespace mle {
namespace {

void WithdrawSmallChanges(const StepResponse& proposed,
                          CorrectionResult& result) {
  Estimate& estimate = result.estimate;
  const StepResponse& initial = result.initial_response;
  for (int i = 0; i < initial.num_outputs; ++i) {
    double largest = 0.0;
    for (int j = 0; j < initial.num_inputs; ++j) {
      largest = std::max(largest, initial.element(i, j).norm());
    }
    bool any = false;
    for (int j = 0; j < initial.num_inputs; ++j) {
      const double norm = initial.element(i, j).norm();
      const double change =
          (proposed.element(i, j) - initial.element(i, j)).norm();
      const bool small =
          change <= LeastChange(result, i, j) * (norm > 0.0 ? norm : largest);
      any = any || !small;
      if (small && ProposesElement(estimate, i, j) &&
          !ProposesByArx(estimate, i)) {
        KeepInitialElement(i, j, estimate);
      }
    }
    if (!any) KeepInitialOutput(i, estimate);
  }
}

}  // namespace

absl::Status WithdrawProposals(int samples, CorrectionResult& result) {
  MLE_ASSIGN_OR_RETURN(const CorrectedModel proposed,
                       MakeCorrectedModel(result.estimate, true,
                                          result.data.sample_time(), samples,
                                          /*make_arx=*/false));
  WithdrawSmallChanges(proposed.response, result);
  result.proposed = result.estimate.fit.output_error.corrected;
  return absl::OkStatus();
}

}  // namespace mle
