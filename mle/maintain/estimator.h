// The estimators of a corrected model, the same under the same name in every
// command, study and benchmark.

#ifndef MLE_MAINTAIN_ESTIMATOR_H_
#define MLE_MAINTAIN_ESTIMATOR_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace mle {

enum class Estimator {
  // Gains, time constants and dead times of the model's elements
  // (structured_correction.h).
  kStructured,
  // ΔR of the ARX model by lasso, any shape of response: the paper's method
  // (correction.h).
  kArx,
  // kStructured, and ΔR for the outputs in which that leaves something that the
  // inputs explain (combined.h).
  kCombined,
};

// In the order of the enum.
const std::vector<Estimator>& AllEstimators();

// "structured", "arx", "combined".
std::string_view NameOf(Estimator estimator);

// The reverse; InvalidArgument lists the names.
absl::StatusOr<Estimator> ParseEstimator(std::string_view name);

}  // namespace mle

#endif  // MLE_MAINTAIN_ESTIMATOR_H_
