// The evidence of a linear model with Gaussian priors,
//
//   e = X a + n,   n ~ N(0, r I),   a ~ N(a₀, D), D diagonal,
//
// from its normal equations G = XᵀX, b = Xᵀe and eᵀe alone, so that priors and
// the noise variance are compared without the rows. Internal to mle/nonlinear.
//
//   −2 ln p(e) = N ln r + ln|M| + (ẽᵀẽ − b̃ᵀ D½ M⁻¹ D½ b̃ / r) / r,
//   M = I + D½ G D½ / r,   ẽ = e − X a₀,   b̃ = b − G a₀
//
// (less N ln 2π). A coefficient of variance 0 stands at its a₀. (MacKay, Neural
// Computation 4, 1992.)

#ifndef MLE_NONLINEAR_LINEAR_EVIDENCE_H_
#define MLE_NONLINEAR_LINEAR_EVIDENCE_H_

#include "Eigen/Core"

namespace mle {

struct LinearPrior {
  Eigen::VectorXd means;      // a₀ (n)
  Eigen::VectorXd variances;  // diagonal of D (n), ≥ 0
};

struct LinearPosterior {
  double deviance = 0.0;       // −2 ln p(e) + const
  Eigen::VectorXd means;       // n
  Eigen::MatrixXd covariance;  // n × n; zero where the variance is 0
  double noise_variance = 0.0;
  // The r that maximises the evidence to first order from this one: squares
  // over the degrees of freedom that are left.
  double next_noise_variance = 0.0;
};

class LinearEvidence {
 public:
  // `rows` N, which need not be that of X: rows that something else has taken
  // up do not count. `constant` is added to every deviance.
  LinearEvidence(const Eigen::MatrixXd& X, const Eigen::VectorXd& e,
                 double rows, double constant);
  // `gram` G, `products` b, `squares` eᵀe.
  LinearEvidence(Eigen::MatrixXd gram, Eigen::VectorXd products, double squares,
                 double rows, double constant);

  double Deviance(const LinearPrior& prior, double noise_variance) const;
  LinearPosterior Posterior(const LinearPrior& prior,
                            double noise_variance) const;

 private:
  Eigen::MatrixXd gram_;      // G
  Eigen::VectorXd products_;  // b
  double squares_ = 0.0;      // eᵀe
  double rows_ = 0.0;
  double constant_ = 0.0;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_LINEAR_EVIDENCE_H_
