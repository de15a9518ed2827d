// Duality gaps along a regularisation path, from the quantities of the path.
//
// Between two knots c and β are straight lines in λ, so that the gap at any λ
// costs one pass over c (duality_gap.h has the formula). Where the gap is not
// small, or rounding of β would dominate it, c is computed from β as the path
// returns it.

#ifndef MLE_REGRESSION_PATH_CERTIFICATE_H_
#define MLE_REGRESSION_PATH_CERTIFICATE_H_

#include "Eigen/Core"
#include "mle/regression/active_set.h"
#include "mle/regression/lasso_path.h"
#include "mle/regression/lasso_problem.h"

namespace mle {

class PathCertificate {
 public:
  // Wanted at `lambdas`, ascending; must outlive the certificate.
  explicit PathCertificate(const Eigen::VectorXd& lambdas);

  // At each wanted λ ≥ end, with what is active above `lambda_max`: the
  // coefficients without penalty.
  void Start(const ActiveSet& active, double lambda_max, double end);
  // At each wanted λ from `lambda`, where the set was solved, down to `end`,
  // which belongs to the segment after it if there is one.
  void Continue(const ActiveSet& active, double lambda, double end,
                bool is_last);
  // Where the path ends, if that is wanted and not certified yet.
  void Finish(const LassoObjective& objective, const LassoPath& path);

  // Relative gap at each λ; ∞ where the path did not reach.
  const Eigen::VectorXd& relative_gap() const { return relative_gap_; }

 private:
  // The largest λ not certified yet; negative where there is none.
  double Next() const { return next_ >= 0 ? lambdas_(next_) : -1.0; }
  double RelativeGap(const ActiveSet& active, double lambda, double step);
  // From c_, which is changed, and β + t q, t = step ≥ 0; λ > 0.
  double GapFromC(const ActiveSet& active, double lambda, double step);

  const Eigen::VectorXd& lambdas_;
  Eigen::VectorXd relative_gap_;
  Eigen::Index next_;  // into lambdas_, from its end
  Eigen::VectorXd c_;
};

}  // namespace mle

#endif  // MLE_REGRESSION_PATH_CERTIFICATE_H_
