// One output of a model in a record: what the model leaves of it and how that
// moves with each parameter, whitened. Internal to mle/monitor.
//
// The parameters of output i are three for each element (i, j) that is present,
// in order of the inputs: the relative changes of its gain and of its time
// constant, and the change of its dead time in units of s,
//
//   ΔK/K,   Δ ln T,   ΔL/s,   s = max(L, T/5, 3 Δt).
//
// With e_k = y_k − Σ_j g_ij u_j the residual of the model as it is and x its
// sensitivities (element_response.h; by dead times the secant over ± s/10, at
// least half a sample), both pass the innovations filter of the noise
// (innovations_filter.h), whose offset is free in each run of known inputs, or
// in each of the groups of its samples. Where an element integrates, a ramp is
// free besides, since the inputs that balance a level are not known: columns
// are the recursive residuals of regression on it (Brown, Durbin and Evans, J.
// R. Stat. Soc. B 37, 1975), and on steps of the level that are found. A run's
// first samples, as long as former inputs act, are not used: all columns are
// then functions of the past, which an anytime-valid test rests on. Where steps
// are is the exception: all samples of a group choose that.

#ifndef MLE_MONITOR_ROW_RESPONSE_H_
#define MLE_MONITOR_ROW_RESPONSE_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {

// A run of samples, in units of √r.
struct WhitenedRun {
  Eigen::VectorXd innovations;    // N, ν
  Eigen::MatrixXd sensitivities;  // N × n: ν moves by these times the change
  int group = 0;                  // of its samples
};

class RowResponse {
 public:
  // `skip`: samples at the begin of a run of known inputs in which former
  // inputs may act. InvalidArgument for elements with feedthrough.
  static absl::StatusOr<RowResponse> Create(const ProcessModel& model,
                                            int output, double sample_time,
                                            int skip);

  // n: three for each element present.
  int num_parameters() const { return 3 * static_cast<int>(inputs_.size()); }
  // Inputs of the elements present.
  const std::vector<int>& inputs() const { return inputs_; }
  // n: the unit of each parameter, 1, 1, s.
  const Eigen::VectorXd& units() const { return units_; }

  // Estimates the noise of the output from its samples that are not NaN, of
  // which there must be 20 at least.
  NoiseEstimate EstimateNoise(const std::vector<Record>& records) const;
  // `groups`: of each sample; empty: all of one. Each group of a run of known
  // inputs has an offset of its own, and free steps where it shows them
  // (step_search.h) by innovations of this deviation or more; 0: none are
  // looked for.
  std::vector<WhitenedRun> Whiten(const Record& record,
                                  const NoiseEstimate& noise,
                                  const std::vector<int>& groups = {},
                                  double step_deviation = 0.0) const;

 private:
  RowResponse() = default;

  OutputErrorProblem ProblemOf(const std::vector<Record>& records) const;
  Eigen::MatrixXd Columns(const OutputErrorProblem& problem,
                          const OutputErrorProblem::Segment& segment) const;

  int output_ = 0;
  int skip_ = 0;
  double sample_time_ = 0.0;
  OutputErrorProblem::Elements elements_;
  OutputPoint point_;
  std::vector<int> inputs_;
  Eigen::VectorXd units_;
};

// 1.4826 times the median of |ν|: a normal variable's standard deviation; 0
// without samples.
double RobustDeviationOf(std::vector<double> values);

}  // namespace mle

#endif  // MLE_MONITOR_ROW_RESPONSE_H_
