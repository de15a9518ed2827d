// Whether the one-step prediction errors of a model still hold something: with
// what came before (whiteness), or with the inputs.
//
// Autocorrelation of output i at lag τ, pooled over windows,
//
//   r_e(τ) = Σ_k e_k e_{k+τ} / Σ_k e_k²,  within ±2.576/√N (99 %) if white,
//
// and Ljung and Box's Q = N (N + 2) Σ_{τ=1}^{L} r_e(τ)²/(N − τ), χ² with L
// degrees of freedom. (Biometrika 65, 1978; degrees of freedom are not reduced
// by the fitted parameters, few against L: p-values are slightly too large.)
//
// Cross-correlation with input j at lag τ, e later than u where τ > 0,
//
//   r_eu(τ) = Σ_k e_{k+τ} u_k / √(Σ e² Σ u²),
//
// with limits 2.576 √(Σ_s r_e(s) r_u(s) / N) (Bartlett). At τ ≤ 0 it shows
// feedback: an input of a closed loop answers to earlier outputs, and to the
// sample measured just before it moves. At τ > 0 it shows dynamics that the
// model lacks. Those lags are judged together: the errors are regressed on the
// input's means over kTestLags stretches of lags, N R² is χ² with as many
// degrees of freedom if the errors are white (Ljung, System Identification,
// 1999, sec. 16.6).

#ifndef MLE_MAINTAIN_RESIDUAL_DIAGNOSTICS_H_
#define MLE_MAINTAIN_RESIDUAL_DIAGNOSTICS_H_

#include <vector>

#include "Eigen/Core"
#include "mle/data/record.h"
#include "mle/maintain/prediction.h"

namespace mle {

inline constexpr double kDiagnosticLevel = 0.01;  // of the limits: 99 %
inline constexpr int kTestLags = 20;

struct InputCorrelation {
  int max_lag = 0;
  Eigen::VectorXd values;  // r_eu(τ), τ = −max_lag … max_lag
  double limit = 0.0;      // 99 %
  // The largest |r_eu| at a lag above 0, and where.
  double largest = 0.0;
  int largest_lag = 0;
  double statistic = 0.0;  // N R²
  int degrees_of_freedom = 0;
  double p_value = 1.0;  // 1 for an input that does not move

  bool correlated() const { return p_value < kDiagnosticLevel; }
};

struct ResidualReport {
  int samples = 0;  // N
  double variance = 0.0;
  Eigen::VectorXd autocorrelation;  // τ = 1 … L
  double limit = 0.0;               // 99 %
  double outside = 0.0;             // share of them beyond the limit
  double ljung_box = 0.0;
  int degrees_of_freedom = 0;
  double p_value = 1.0;
  std::vector<InputCorrelation> inputs;  // m

  bool white() const { return p_value >= kDiagnosticLevel; }
};

// One for each output. `max_lag` ≥ 1 in samples; shorter where windows are.
std::vector<ResidualReport> ExamineResiduals(const Predictor& predictor,
                                             const std::vector<Record>& windows,
                                             int max_lag, int threads = 1);

}  // namespace mle

#endif  // MLE_MAINTAIN_RESIDUAL_DIAGNOSTICS_H_
