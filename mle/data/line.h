// Series without a straight line: the residual of an output that integrates,
// whose level and balance are not known. Internal to the project.

#ifndef MLE_DATA_LINE_H_
#define MLE_DATA_LINE_H_

#include "Eigen/Core"

namespace mle {

// Less the line of least squares of the finite values.
Eigen::VectorXd WithoutLine(const Eigen::VectorXd& values);

}  // namespace mle

#endif  // MLE_DATA_LINE_H_
