// Whether outputs drive inputs: the test of Granger (Econometrica 37, 1969;
// for control loops Caines and Chan, IEEE Trans. Automatic Control 20, 1975).
//
//   u_k = Σ_l A_l u_{k−l} + Σ_l b_l e_{k−l} + Σ_l C_l r_{k−l} + c + white,
//
// The hypothesis is b = 0, tested for each input u in turn. r are the set
// points that move; their lags l begin at 0, those of u and e at 1. e is the
// residual of the model without what instruments drive of it (instruments.h),
// in rows of a tenth of τ. What disturbs an output is in e, so that a
// controller's answer to it is in b. The test does not depend on the spectrum
// of the disturbances, since the residual of this regression is white.

#ifndef MLE_EXPLAIN_FEEDBACK_H_
#define MLE_EXPLAIN_FEEDBACK_H_

#include <optional>
#include <vector>

#include "Eigen/Core"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

class ExplainedOutput;

// The p-value of b = 0: the probability that e predicts some input of the
// output this well by chance, were there no feedback. There is none where the
// rows are too few to test.
std::optional<double> FeedbackPValue(const ExplainedOutput& output,
                                     const Eigen::VectorXd& e);
// The same p-value of output i of `model` in records that match the model.
// There is none, either, where no input reaches the output or no input moves.
std::optional<double> FeedbackPValue(const ProcessModel& model,
                                     const std::vector<Record>& records, int i);

}  // namespace mle

#endif  // MLE_EXPLAIN_FEEDBACK_H_
