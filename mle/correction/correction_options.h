// Options of the paper's method: the conversion of a process model into an ARX
// model (conversion.h), the correction of that by records (correction.h) and
// the choice of its penalty λ (selection.h).

#ifndef MLE_CORRECTION_CORRECTION_OPTIONS_H_
#define MLE_CORRECTION_CORRECTION_OPTIONS_H_

#include <functional>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/regression/lasso_options.h"

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

struct SelectionOptions {
  enum class Rule { kLeaveChangeOut, kBlocks, kAic, kBic, kGcv };
  Rule rule = Rule::kBlocks;
  int folds = 5;  // of kBlocks, ≥ 2
  // For kBlocks: the samples of a block, ≥ 0; 0 takes twice the model's order.
  int block_length = 0;
  // For kBlocks, ≥ 1: the number of times that the windows are cut, each time
  // that part of a block later; the losses are added.
  int phases = 2;
  // Samples predicted before measured outputs are used again: 1 predicts one
  // step ahead, 0 simulates every window from its start, −1 takes a fifth of
  // the model's order. But for 1 the mean residual of a run of rows is taken
  // off. For cross-validation only; the paper's rule has 1.
  int horizon = -1;
  // The largest λ whose loss is within one standard error of the smallest
  // (Hastie, Tibshirani and Friedman, The Elements of Statistical Learning, 2nd
  // ed., 7.10). For cross-validation only.
  bool one_standard_error = false;
  // A λ for each output rather than one for all.
  bool per_output = false;
  // For kBlocks, ≥ 0: the standard deviations by which Ê at λ* may exceed the
  // least Ê; 0 takes the λ of least loss in any case. Not used with per_output.
  double response_deviations = 2.0;
  // λ* among the values of the grid; else, where the loss is known exactly,
  // among all λ ≥ 0.
  bool on_grid = false;

  absl::Status Validate() const;
  bool operator==(const SelectionOptions&) const = default;

  // Block length and horizon for a model of order `order`.
  int BlockLength(int order) const;
  int Horizon(int order) const;
};

struct CorrectionOptions {
  // Ascending, ≥ 0, not empty; the paper's are 0, 1e-6, …, 1e-2.
  Eigen::VectorXd lambdas = {};
  Scaling scaling = Scaling::kStandardise;
  // An intercept for each window rather than one for all: for records whose
  // operating points, or slow disturbances, differ. Only if standardised.
  bool window_intercepts = false;
  // p × n, or empty for ones: weight of each coefficient's penalty, ≥ 0. 0
  // leaves it free, ∞ holds it: for inputs known not to reach an output, or
  // lags shorter than a known dead time.
  Eigen::MatrixXd penalty_weights = {};
  SelectionOptions selection = {};
  LassoSolverOptions solver = {};

  absl::Status Validate() const;
};

}  // namespace mle

#endif  // MLE_CORRECTION_CORRECTION_OPTIONS_H_
