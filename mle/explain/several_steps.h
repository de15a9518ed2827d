// Plain least squares of predictions several steps ahead: gain, time constant
// and dead time of all elements of an output at once, and second lags, without
// a noise model.
//
//   min over θ  Σ_h Σ_k (e_k − e_{k−h})² / S_h  +  Σ_i (ε θ_i)²,
//
// h = τ/5, τ, 3 τ, S_h the same sum of the model as it was, e the residual of
// free simulation (explained_output.h), ε small: a parameter of which records
// say nothing stays. Where a model is wrong in everything, a likelihood one
// step ahead gives what is slow to coloured noise and runs away with gains and
// time constants, and single explanations hide each other; this does neither.
// Those θ stay at 0 that lower the sum by less than a fiftieth, or are not
// significant (5 %) by the jackknife over the folds of held-out blocks.
// Internal to mle/explain.

#ifndef MLE_EXPLAIN_SEVERAL_STEPS_H_
#define MLE_EXPLAIN_SEVERAL_STEPS_H_

#include <array>
#include <vector>

#include "Eigen/Core"
#include "mle/explain/competition.h"
#include "mle/explain/explained_output.h"
#include "mle/explain/explanation.h"
#include "mle/explain/explanation_fit.h"
#include "mle/explain/instruments.h"

namespace mle {

// Horizons in τ.
inline constexpr std::array<double, 3> kStepsAhead = {0.2, 1.0, 3.0};

// A time in rows of the output, at least one.
int InRows(const ExplainedOutput& output, double time);

// Whether nothing is missing between a row and the one `ahead` before it.
bool Reaches(const std::vector<ResidualRow>& rows, std::size_t i, int ahead);

struct SeveralStepsFit {
  std::vector<Explanation> explanations;
  std::vector<HorizonErrors> held_out;
  Eigen::MatrixXd covariance;  // of θ
};

class SeveralSteps {
 public:
  // Both must outlive it.
  SeveralSteps(const ExplainedOutput& output, const Instruments& instruments);

  // With second lags of elements of first order, or without. Nothing where the
  // squares of the errors that a fit of all leaves in all records, in those of
  // the model as it is, add up to more than `most` over the horizons: held out
  // they would be larger still.
  SeveralStepsFit Best(bool second_lags, double most) const;

 private:
  // θ of these from the rows of weight one.
  ExplanationFit Fit(std::vector<Explanation> explanations,
                     const Eigen::VectorXd& weights) const;
  // Those of all that are worth it.
  std::vector<Explanation> Worth(bool second_lags, double most) const;
  // Errors held out and the covariance of θ̂, by the fits without a fold each.
  void FitFolds(SeveralStepsFit& fit) const;
  Eigen::VectorXd ErrorsAt(const std::vector<Explanation>& explanations,
                           const Eigen::VectorXd& weights) const;
  ExplanationValue Errors(const Eigen::VectorXd& weights) const;

  const ExplainedOutput& output_;
  const Instruments& instruments_;
  std::array<int, kStepsAhead.size()> ahead_;  // rows
  std::array<double, kStepsAhead.size()> scales_;
};

}  // namespace mle

#endif  // MLE_EXPLAIN_SEVERAL_STEPS_H_
