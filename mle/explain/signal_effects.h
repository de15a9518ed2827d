// What explanations do to a signal z, sample by sample. Internal to
// mle/explain.

#ifndef MLE_EXPLAIN_SIGNAL_EFFECTS_H_
#define MLE_EXPLAIN_SIGNAL_EFFECTS_H_

#include "Eigen/Core"

namespace mle {

// The response of a first-order element of gain one to `input`, with the time
// constant `falling` where its output times `sign` falls.
Eigen::VectorXd TwoLags(double rising, double falling, double sample_time,
                        double delay, double sign,
                        const Eigen::VectorXd& input);

// z as it is `samples` later, not necessarily whole ones; its last value after
// the end.
Eigen::VectorXd Earlier(const Eigen::VectorXd& z, double samples);

// The mean of z over the last `width` samples, not necessarily whole ones.
Eigen::VectorXd Averaged(const Eigen::VectorXd& z, double width);

}  // namespace mle

#endif  // MLE_EXPLAIN_SIGNAL_EFFECTS_H_
