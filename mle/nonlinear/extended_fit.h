// The likelihood of a fit with columns besides: what a disturbance, or a
// response to the inputs that the model lacks, explains of its residuals.
// Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_EXTENDED_FIT_H_
#define MLE_NONLINEAR_EXTENDED_FIT_H_

#include <array>
#include <optional>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

// To first order about `fit`, whose free parameters are fitted beside the
// columns. Both must outlive it. For one thread.
class ExtendedFit {
 public:
  ExtendedFit(const OutputErrorProblem& problem, const OutputFit& fit,
              bool estimate_drift);

  const OutputErrorProblem& problem() const { return problem_; }
  const OutputFit& fit() const { return fit_; }
  // The columns of each segment, linearised at the fit.
  const std::vector<SegmentColumns>& columns() const { return columns_; }

  // `more`: columns of each segment (rows × k), one coefficient for each.
  ShapeLikelihood With(const std::vector<Eigen::MatrixXd>& more) const;
  // The likeliest shape with them; `start` and `search_ar` as of
  // FindBestShape().
  Profile Best(const std::vector<Eigen::MatrixXd>& more,
               const NoiseShape& start, bool search_ar) const;

  // The likeliest shape of any AR component without anything besides.
  const Profile& Without() const;

  // Whether −2 ln L falls by `gain` or more, beyond Schwarz's price, where
  // responses to the inputs are added: sums over ranges of lags, or for each
  // element those with other time scales, which is what its shape may lack.
  // Effects of inputs that the model lacks are not a disturbance.
  bool InputsGain(double gain) const;

 private:
  static constexpr int kInputColumns = 3;  // sets of them
  std::vector<Eigen::MatrixXd> InputColumns(int set) const;

  const OutputErrorProblem& problem_;
  const OutputFit& fit_;
  bool estimate_drift_;
  std::vector<SegmentColumns> columns_;
  // Made when they are asked for.
  mutable std::optional<ShapeLikelihood> likelihood_;  // without anything
  mutable std::optional<Profile> without_;
  mutable std::array<std::optional<double>, kInputColumns> gains_;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_EXTENDED_FIT_H_
