// The expected value of each output sample under a model of the plant, given
// all other samples: to detect outliers and to replace missing samples.
//
//   y_k = x_k + w_k + e_k,   w_{k+1} = w_k + ξ_k,
//
// x is the model's response to the record's inputs, settled at the first of
// them; w a random walk with the noise's ratio ρ = Var ξ / Var e, or, where
// that is slower, as fast as the output's fastest time scale T, ρ ≥ (Δt/T)²: so
// w also follows the effect of inputs before the record and the residual of a
// model that is not quite the plant's. w is the fixed-interval smoother's
// (innovations_filter.h), with Cauchy's weights (robust_loss.h), beginning at a
// running median, which single outliers and bursts do not bias. Neighbours
// alone cannot distinguish a burst from a movement of the output; the model
// knows how the inputs moved.
//
//   MLE_ASSIGN_OR_RETURN(const OutlierReport report,
//                        MarkOutliers(model, {}, {}, windows));  // → NaN
//   MLE_ASSIGN_OR_RETURN(const OutputErrorCorrection fit,
//                        CorrectByOutputError(model, windows, {}));
//   MLE_ASSIGN_OR_RETURN(const int filled,       // for a regression on lags
//                        FillOutputs(fit.full.model, fit.full.noise, 30,
//                                    windows));
//
// docs/estimators.md has measured results.

#ifndef MLE_NONLINEAR_OUTPUT_RECONSTRUCTION_H_
#define MLE_NONLINEAR_OUTPUT_RECONSTRUCTION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// x + w, p × samples: NaN where inputs are not known, or no output is within
// the same run of known inputs. `noise`: p, of which the ratios count.
// InvalidArgument if the record is not of the model's channels, an element has
// feedthrough, or noise is not given for each output.
absl::StatusOr<Eigen::MatrixXd> ExpectedOutputs(
    const ProcessModel& model, const std::vector<NoiseEstimate>& noise,
    const Record& record);

struct OutlierMarkOptions {
  // A sample is an outlier that lies farther from what is expected than so many
  // robust standard deviations of all that do not, > 0.
  double threshold = 5.0;
  // More outliers than this in a row are a disturbance and are kept. ≥ 1.
  int longest_burst = 25;

  absl::Status Validate() const;
};

struct OutlierReport {
  std::vector<int> marked;   // p: samples that are NaN now
  std::vector<int> bursts;   // p: runs of them
  std::vector<int> longest;  // p: most in a row
  // p: samples as far off that are kept, as part of a disturbance.
  std::vector<int> left;
};

// Marks the outliers of the records' outputs as bad (NaN): outliers under the
// output-error correction of `initial` with Cauchy's loss, fitted without the
// outliers under `initial` itself. Errors as of CorrectByOutputError() and
// ExpectedOutputs().
absl::StatusOr<OutlierReport> MarkOutliers(
    const ProcessModel& initial, const OutputErrorOptions& output_error,
    const OutlierMarkOptions& options, std::vector<Record>& records);

// Replaces missing outputs by their expected values, up to `max_gap` of them in
// a row (≥ 0), between good samples; returns how many. Errors as of
// ExpectedOutputs(), of the outputs that miss some.
absl::StatusOr<int> FillOutputs(const ProcessModel& model,
                                const std::vector<NoiseEstimate>& noise,
                                int max_gap, std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_RECONSTRUCTION_H_
