// Whether outputs drive inputs: the test of Granger (Econometrica 37, 1969;
// for control loops Caines and Chan, IEEE Trans. Automatic Control 20, 1975).
//
//   u_k = Σ_l A_l u_{k−l} + Σ_l b_l e_{k−l} + c + white,   b = 0?
//
// for each input in turn, e the residual of the model without what inputs drive
// of it (instruments.h), in rows of a tenth of τ. What disturbs an output is in
// e, so that a controller's answer to it is in b. The test does not depend on
// the colour of disturbances: what is left of u is white.
//
// Internal to mle/explain.

#ifndef MLE_EXPLAIN_FEEDBACK_H_
#define MLE_EXPLAIN_FEEDBACK_H_

#include <optional>

#include "mle/explain/explained_output.h"

namespace mle {

// The p-value of b = 0: the probability that e predicts some input of the
// output this well by chance, were there no feedback. Nothing where there are
// too few rows to test.
std::optional<double> FeedbackPValue(const ExplainedOutput& output,
                                     const Eigen::VectorXd& e);

}  // namespace mle

#endif  // MLE_EXPLAIN_FEEDBACK_H_
