// Correction of an ARX model from windows of closed-loop records (the paper's
// Eq. 3 and its choice of λ):
//
//   ΔR(λ) = argmin 1/(2N) ‖Y − (R + ΔR) X‖_F² + λ ‖ΔR‖₁,
//
// for every λ of a grid, with λ* chosen by cross-validation between the
// windows. The outputs separate: one lasso problem each, with response Y − RX.
//
//   MLE_ASSIGN_OR_RETURN(const Correction correction,
//                        CorrectModel(initial, windows, options));
//   correction.Model();   // with λ*

#ifndef MLE_CORRECTION_CORRECTION_H_
#define MLE_CORRECTION_CORRECTION_H_

#include <memory>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "mle/correction/correction_options.h"
#include "mle/correction/regression_data.h"
#include "mle/correction/selection.h"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

// {0, step, 2 step, …, max}: every multiple of step up to max and a rounding.
absl::StatusOr<Eigen::VectorXd> MakeLambdaGrid(double max, double step);

class Correction {
 public:
  const SelectionSummary& selection() const { return selection_; }
  const SelectionOptions& selection_options() const {
    return selection_options_;
  }
  // The fit of each output to all windows.
  const std::vector<LassoSolution>& fits() const { return fits_; }
  // The problems of these fits, and the weights of their penalties (p × n, or
  // empty for ones).
  const LassoProblem& problem() const { return problem_; }
  const Eigen::MatrixXd& penalty_weights() const { return penalty_weights_; }
  const ArxModel& initial() const { return initial_; }
  // The rows, their moments, and how the problem was made from these.
  const RegressionData& data() const { return *data_; }
  const LaggedMoments& moments() const { return moments_; }
  Scaling scaling() const { return scaling_; }
  // Worst relative duality gap of all fits, at every λ of the grid.
  double MaxRelativeGap() const;

  // R + ΔR with λ*, with a λ for each output (p), with one for all.
  ArxModel Model() const { return Model(selection_.lambda_star); }
  ArxModel Model(const Eigen::VectorXd& lambdas) const;
  ArxModel Model(double lambda) const;
  // The same into a model that is used again and again.
  void Model(const Eigen::VectorXd& lambdas, ArxModel& model) const;

  // λ* by another rule, on the same fits.
  absl::Status Select(const SelectionOptions& options);

 private:
  friend absl::StatusOr<Correction> CorrectModel(
      const ArxModel& initial, absl::Span<const Record> windows,
      const CorrectionOptions& options);

  ArxModel initial_;
  Scaling scaling_ = Scaling::kStandardise;
  LassoSolverOptions solver_;
  std::shared_ptr<const RegressionData> data_;
  LaggedMoments moments_;
  LassoProblem problem_;
  Eigen::MatrixXd penalty_weights_;
  SelectionSummary selection_;
  SelectionOptions selection_options_;
  std::vector<LassoSolution> fits_;
};

absl::StatusOr<Correction> CorrectModel(const ArxModel& initial,
                                        absl::Span<const Record> windows,
                                        const CorrectionOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_CORRECTION_H_
