#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/robust_statistics.h"
#include "mle/nonlinear/output_reconstruction.h"
#include "mle/nonlinear/robust_loss.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Noise below this share of an output's range is rounding.
constexpr double kSmallestRelativeNoise = 1e-5;

// Runs of samples farther off than `limit`, first and how many.
struct Run {
  int first = 0;
  int samples = 0;
};

std::vector<Run> RunsBeyond(double limit, const Eigen::RowVectorXd& errors) {
  std::vector<Run> runs;
  for (int k = 0; k < errors.size(); ++k) {
    if (!(std::abs(errors(k)) > limit)) continue;
    if (runs.empty() || runs.back().first + runs.back().samples < k) {
      runs.push_back({.first = k, .samples = 0});
    }
    ++runs.back().samples;
  }
  return runs;
}

// The noise's robust deviation in all errors of an output.
double DeviationOf(const std::vector<MatrixXd>& errors,
                   const std::vector<Record>& records, int output) {
  std::vector<double> sizes;
  double min = std::numeric_limits<double>::infinity();
  double max = -min;
  for (std::size_t r = 0; r < errors.size(); ++r) {
    for (Index k = 0; k < errors[r].cols(); ++k) {
      const double error = errors[r](output, k);
      if (!std::isfinite(error)) continue;
      sizes.push_back(std::abs(error));
      min = std::min(min, records[r].outputs(output, k));
      max = std::max(max, records[r].outputs(output, k));
    }
  }
  if (sizes.empty()) return std::numeric_limits<double>::infinity();
  return std::max(1.4826 * MedianInPlace(sizes),
                  kSmallestRelativeNoise * (max - min));
}

// Marks what the model does not believe.
absl::StatusOr<OutlierReport> JudgeOutliers(
    const ProcessModel& model, const std::vector<NoiseEstimate>& noise,
    const OutlierMarkOptions& options, std::vector<Record>& records) {
  std::vector<MatrixXd> errors;
  for (const Record& record : records) {
    MLE_ASSIGN_OR_RETURN(const MatrixXd expected,
                         ExpectedOutputs(model, noise, record));
    errors.push_back(record.outputs - expected);
  }
  const int p = model.num_outputs();
  OutlierReport report;
  report.marked.assign(p, 0);
  report.bursts.assign(p, 0);
  report.longest.assign(p, 0);
  report.left.assign(p, 0);
  for (int i = 0; i < p; ++i) {
    const double limit = options.threshold * DeviationOf(errors, records, i);
    for (std::size_t r = 0; r < records.size(); ++r) {
      for (const Run& run : RunsBeyond(limit, errors[r].row(i))) {
        if (run.samples > options.longest_burst) {
          report.left[i] += run.samples;
          continue;
        }
        records[r]
            .outputs.row(i)
            .segment(run.first, run.samples)
            .setConstant(kNaN);
        report.marked[i] += run.samples;
        ++report.bursts[i];
        report.longest[i] = std::max(report.longest[i], run.samples);
      }
    }
  }
  return report;
}

}  // namespace

absl::Status OutlierMarkOptions::Validate() const {
  if (!(threshold > 0.0) || !std::isfinite(threshold)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "outliers: threshold is ", threshold, ", must be finite and positive"));
  }
  if (longest_burst < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "outliers: longest_burst is ", longest_burst, ", must be at least 1"));
  }
  return absl::OkStatus();
}

absl::StatusOr<OutlierReport> MarkOutliers(
    const ProcessModel& initial, const OutputErrorOptions& output_error,
    const OutlierMarkOptions& options, std::vector<Record>& records) {
  MLE_RETURN_IF_ERROR(options.Validate());
  OutputErrorOptions robust = output_error;
  robust.robust_loss = RobustLoss::kCauchy;
  // A loss does not always keep a fit from bending to a burst in the middle of
  // a response. So what the initial model does not believe is left out of it.
  std::vector<Record> to_fit = records;
  const std::vector<NoiseEstimate> unknown(initial.num_outputs());
  MLE_RETURN_IF_ERROR(robust.Validate());
  MLE_RETURN_IF_ERROR(
      JudgeOutliers(initial, unknown, options, to_fit).status());
  MLE_ASSIGN_OR_RETURN(const OutputErrorFit fit,
                       FitAllElements(initial, to_fit, robust));
  return JudgeOutliers(fit.model, fit.noise, options, records);
}

}  // namespace mle
