// Standard errors of a least-squares fit, but for the noise.

#ifndef MLE_NONLINEAR_UNIT_ERRORS_H_
#define MLE_NONLINEAR_UNIT_ERRORS_H_

#include "Eigen/Core"

namespace mle {

// Square roots of the diagonal of (JᵀJ)⁻¹ for the Jacobian J (n × k) of the
// residuals at the fit; +∞ for a parameter that has a part in a direction
// without effect. Times the residuals' deviation they are standard errors.
Eigen::VectorXd UnitErrors(const Eigen::MatrixXd& jacobian);

}  // namespace mle

#endif  // MLE_NONLINEAR_UNIT_ERRORS_H_
