// Whitening of a sampled disturbance that is a random walk, a coloured
// component and white noise,
//
//   n_k = w_k + a_k + e_k,   w_{k+1} = w_k + ξ_k,
//   Var e = r,   Var ξ = q = ρ r,
//
// with a of first or second order and shocks of variance s = σ r
// (ar_component.h), by its time-varying Kalman filter. The walk has a diffuse
// start (nothing is known of w_0, so that the first sample sets it: one free
// offset); a starts stationary. Without an AR component, in units of r,
//
//   ν_k = n_k − ŵ_k,   F_k = P_k + 1,   ŵ_{k+1} = ŵ_k + (P_k/F_k) ν_k,
//   P_{k+1} = P_k/F_k + ρ,
//
// and with it the same for the state (w, a) or (w, a, b) and its covariance P,
// Π − P in place of P being what the stationary Π loses by what is known; gaps
// of d samples are bridged by dρ and F^d. ν_k/√F_k is white with variance r and
// −2 ln p(n) = Σ (ln(2π r F_k) + ν_k²/(r F_k)), k ≥ 1. The filter is linear in
// n, so that a model's residuals and its Jacobian pass through it alike.
// Samples may have weights ω_k: Var e_k = r/ω_k, F_k = P_k + 1/ω_k. (Durbin and
// Koopman, Time Series Analysis by State Space Methods, 2nd ed. 2012, ch. 2, 4
// and 5.)
//
//   const InnovationsFilter filter(times, {.ratio = 1e-3});
//   filter.Apply(columns);

#ifndef MLE_NONLINEAR_INNOVATIONS_FILTER_H_
#define MLE_NONLINEAR_INNOVATIONS_FILTER_H_

#include <functional>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/ar_component.h"

namespace mle {

struct NoiseShape {
  double ratio = 0.0;  // ρ ≥ 0, finite
  // Without an offset w is zero and ρ is 0: white noise passes unchanged.
  bool offset = true;
  double ar_ratio = 0.0;    // σ ≥ 0, finite; 0: no coloured component
  double ar_pole = 0.0;     // φ, a sample, in [0, 1)
  double ar_damping = 0.0;  // ζ ≥ 0, finite; 0: first order

  ArComponent ar() const { return ArComponent(ar_pole, ar_damping); }
  bool has_ar() const { return ar_ratio > 0.0; }
  bool operator==(const NoiseShape& other) const = default;
};

using RowMajorMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class InnovationsFilter {
 public:
  // `times` are the numbers of the samples present, increasing; between them
  // the random walk and the AR component continue.
  // `weights`, of each sample, are > 0; empty for ones.
  InnovationsFilter(const std::vector<int>& times, const NoiseShape& shape,
                    const Eigen::VectorXd& weights = {});

  // Σ ln F_k over the innovations: one fewer than the samples with an offset.
  double log_determinant() const { return log_determinant_; }

  // Each column becomes its ν_k/√F_k; the first row, taken up by the offset,
  // becomes 0 where there is one. As many rows as samples.
  void Apply(Eigen::Ref<Eigen::MatrixXd> columns) const;

  // CᵀC of the columns C that Apply() would make of `columns`, for N samples
  // and w columns N w (w + 9) operations in blocks that stay in the cache. All
  // of the symmetric matrix.
  //
  // Columns may end, as free responses do: column c is zero from row ends[c] on
  // (`ends` is empty where none does). What the filter makes of zeros is linear
  // in its state there, up to three numbers, so that all columns that have
  // ended take no more operations than three.
  Eigen::MatrixXd WhitenedProducts(
      const RowMajorMatrix& columns,
      const std::vector<Eigen::Index>& ends = {}) const;
  // The same of `width` columns that are made when they are needed: of `count`
  // samples, from `first` on, those of `columns` (ascending), one row after the
  // other, `stride` numbers from one to the next. All samples are asked for in
  // turn.
  using RowSource = std::function<void(Eigen::Index first, Eigen::Index count,
                                       const std::vector<Eigen::Index>& columns,
                                       double* rows, Eigen::Index stride)>;
  Eigen::MatrixXd WhitenedProducts(Eigen::Index width, const RowSource& source,
                                   const std::vector<Eigen::Index>& ends) const;

  // The expected e_k given all of n (as many as samples): n less the smoothed
  // random walk and AR component.
  Eigen::VectorXd WhitePart(const Eigen::VectorXd& disturbance) const;

 private:
  void SetUpWhite(const Eigen::VectorXd& weights);
  void SetUpWalk(const std::vector<int>& times, double ratio,
                 const Eigen::VectorXd& weights);
  template <int kOrder>
  void SetUpAr(const std::vector<int>& times, const NoiseShape& shape,
               const Eigen::VectorXd& weights);
  // Passes `count` rows of `width` numbers, the first that of sample `first`,
  // from `state` (width × 3) on.
  void FilterRows(Eigen::Index first, Eigen::Index count, double* rows,
                  Eigen::Index width, Eigen::MatrixXd& state) const;
  Eigen::VectorXd PartWithoutAr(const Eigen::VectorXd& disturbance) const;

  std::vector<double> gains_;          // of w: P_k/F_k
  std::vector<double> inverse_roots_;  // 1/√F_k
  // The gain from the error of ŵ_{k+1} before its sample to that of ŵ_k,
  // P_k r/P_{k+1}.
  std::vector<double> smoothing_;
  // With an AR component, d samples to the next one: F^d and F^d times the
  // gain. FilterSteps (kernels) reads it as numbers in turn.
  struct ArStep {
    ArComponent::Power power;
    double gain_a = 0.0;
    double gain_b = 0.0;
  };
  static_assert(sizeof(ArStep) == 4 * sizeof(double));
  std::vector<ArStep> ar_;
  double spread_ = 0.0;
  std::vector<double> white_;  // with an AR component: 1/ω_k
  bool offset_ = true;
  double log_determinant_ = 0.0;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_INNOVATIONS_FILTER_H_
