// The error of a correction's step responses, estimated from the records.
//
// Prediction losses are nearly blind to errors of gains (docs/selection.md).
// The error wanted is E(λ) = ‖S(R + ΔR(λ)) − S*‖², S the step responses of all
// pairs and samples 0 … N. Ŝ₀ of the least-squares fit, λ = 0, has variance but
// hardly bias; so, with J = ∂S/∂R at that fit,
//
//   Ê(λ) = ‖S(λ) − Ŝ₀‖² + 2 tr(J V(λ) Jᵀ) − tr(J V(0) Jᵀ),
//   V_q(λ) = σ̂_q² G_AA⁻¹ / M,   σ̂_q² = ‖residual of least squares‖² / (M − n),
//
// V_q the covariance of row q of R given its active set A (M rows, n columns).
// ‖S(λ) − Ŝ₀‖² is the squared bias plus tr J(V(0) − V(λ))Jᵀ, the variance of a
// difference from the fit of all columns. The noise of Ŝ₀ gives Ê a standard
// deviation of up to √(2 tr K²), K = J V(0) Jᵀ, that is the same for all λ.
//
// Sources: Claeskens and Hjort, The focused information criterion, J. Am. Stat.
// Assoc. 98 (2003); Hausman, Specification tests in econometrics, Econometrica
// 46 (1978), for the variance of the difference.

#ifndef MLE_CORRECTION_RESPONSE_RISK_H_
#define MLE_CORRECTION_RESPONSE_RISK_H_

#include <optional>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "absl/types/span.h"
#include "mle/model/arx_model.h"
#include "mle/model/step_response.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

// ∂S/∂R_q of row q ≥ 0 of R at `model`: a row for each pair (i, j), input by
// input, and each of `samples` (≥ 0, ascending) within it, a column for each
// regressor. With H the response of (I − A)⁻¹ and x⁽ʲ⁾ the regressors after a
// unit step of input j,
//
//   ∂S_ij(k)/∂R_q = Σ_{t ≤ k} H_iq(k − t) x⁽ʲ⁾(t)ᵀ.
Eigen::MatrixXd StepResponseSensitivity(const ArxModel& model, int q,
                                        const std::vector<int>& samples);

class ResponseRisk {
 public:
  // `initial` is R, `problem` that of all rows with a response for each output;
  // both must outlive the object. `penalty_weights` p × n or empty: columns
  // with an infinite weight stay at zero. `samples` ≥ 1 is N + 1. None where
  // least squares does not determine the model: no more rows than columns,
  // dependent columns, step responses ten times as large as those of R, or with
  // squares that the standard deviation exceeds.
  static std::optional<ResponseRisk> Create(
      const ArxModel& initial, const LassoProblem& problem,
      const Eigen::MatrixXd& penalty_weights, int samples);

  // Ê of the coefficients of `fits` (p) at λ ≥ 0; infinite where the step
  // responses do not settle.
  double operator()(absl::Span<const LassoSolution> fits, double lambda) const;
  // √(2 tr K²).
  double deviation() const { return deviation_; }
  // tr K: E to be expected of least squares.
  double variance() const { return variance_; }

 private:
  ResponseRisk(const ArxModel& initial, const LassoProblem& problem,
               int samples);

  // The fit of an output without penalty.
  struct LeastSquares {
    std::vector<int> columns;
    Eigen::LLT<Eigen::MatrixXd> factor;  // of their G
    Eigen::VectorXd beta;
  };
  // False where it is not determined.
  bool FitLeastSquares(const Eigen::MatrixXd& penalty_weights,
                       std::vector<LeastSquares>& fits);
  double VarianceOf(int q, const std::vector<int>& active) const;

  const ArxModel& initial_;
  const LassoProblem& problem_;
  int samples_;
  StepResponse least_squares_;
  // By output: J in the problem's units, and σ̂²/M.
  std::vector<Eigen::MatrixXd> sensitivity_;
  Eigen::VectorXd noise_;
  double variance_ = 0.0;
  double deviation_ = 0.0;
};

}  // namespace mle

#endif  // MLE_CORRECTION_RESPONSE_RISK_H_
