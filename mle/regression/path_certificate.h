// Duality gaps along a regularisation path, from what the path holds already.
//
// Between two knots c and β are straight lines in λ, so that the gap at any λ
// costs one pass over c (duality_gap.h has the formula).

#ifndef MLE_REGRESSION_PATH_CERTIFICATE_H_
#define MLE_REGRESSION_PATH_CERTIFICATE_H_

#include "Eigen/Core"
#include "mle/regression/active_set.h"

namespace mle {

class PathCertificate {
 public:
  // Wanted at `lambdas`, ascending; must outlive the certificate.
  explicit PathCertificate(const Eigen::VectorXd& lambdas);

  // At each wanted λ ≥ end, with what is active above `lambda_max`: the
  // coefficients without penalty.
  void Start(const ActiveSet& active, double lambda_max, double end);
  // At each wanted λ from `lambda`, where the set was solved, down to `end`. c
  // may be sharpened for it.
  void Continue(ActiveSet& active, double lambda, double end);

  // Relative gap at each λ; ∞ where the path did not reach.
  const Eigen::VectorXd& relative_gap() const { return relative_gap_; }

 private:
  bool Wanted(double end) const;
  // The gap at λ > 0 from c − t b and β + t q, t = step ≥ 0.
  double RelativeGap(const ActiveSet& active, double lambda, double step);

  const Eigen::VectorXd& lambdas_;
  Eigen::VectorXd relative_gap_;
  Eigen::Index next_;  // into lambdas_, from its end
  Eigen::VectorXd c_;
};

}  // namespace mle

#endif  // MLE_REGRESSION_PATH_CERTIFICATE_H_
