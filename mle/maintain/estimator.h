// The estimators of a corrected model and the tests that guard them, the same
// under the same name in every command, study and benchmark.

#ifndef MLE_MAINTAIN_ESTIMATOR_H_
#define MLE_MAINTAIN_ESTIMATOR_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace mle {

enum class Estimator {
  // Gains, time constants and dead times of the model's elements
  // (output_error_correction.h).
  kOutputError,
  // ΔR of the ARX model by lasso, any shape of response: the paper's method
  // (correction.h).
  kArx,
};

// The test by which a change is proposed at all.
enum class ChangeTest {
  // The likelihood-ratio test of the output-error correction, calibrated on
  // simulated records where χ² leaves doubt (no_change_test.h).
  kCalibrated,
  // The same test by χ² alone.
  kChiSquare,
  // Whether the inputs explain part of the initial model's residuals
  // (model_adequacy.h), without any structure: for kArx alone.
  kAdequacy,
  // Nothing: ΔR, or the fit with every element free, is proposed as it is.
  kNone,
};

// In the order of the enum.
const std::vector<Estimator>& AllEstimators();

// "output_error", "arx".
std::string_view NameOf(Estimator estimator);
// "calibrated", "chi_square", "adequacy", "none".
std::string_view NameOf(ChangeTest test);

// The reverse; InvalidArgument lists the names.
absl::StatusOr<Estimator> ParseEstimator(std::string_view name);
absl::StatusOr<ChangeTest> ParseChangeTest(std::string_view name);

}  // namespace mle

#endif  // MLE_MAINTAIN_ESTIMATOR_H_
